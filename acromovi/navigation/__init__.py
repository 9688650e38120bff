"""The indoor navigation for people: started by its wiring file, sent somewhere, looked at."""
