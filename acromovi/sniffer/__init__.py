"""What agents say to each other, overheard: read, put in order, and drawn as sequence diagrams in text and SVG."""
