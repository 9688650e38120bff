"""`acromovi map`: maps of buildings, built by robots."""
