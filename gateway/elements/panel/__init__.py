"""What is on the user panel and beside it: charger, display, power outputs, servos."""
