"""Conformance suite for anything that claims to speak P2OS on a port: emulated, simulated or real.

It does its own arithmetic on the bytes and imports none of the packages it judges.
"""
