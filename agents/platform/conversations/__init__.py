"""Conversations between agents: requests, queries, subscriptions and contract nets after FIPA.

The initiator's side begins in `initiator`, and each of its conversations is an `InitiatorConversation`. The responder's
side begins in `request_dispatcher`, and each of its conversations is a `ResponderConversation`.
"""
