"""What every robot has: wheels, battery, user ports, sonar, bumpers, and the controller's own configuration."""
