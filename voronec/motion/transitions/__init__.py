"""What ends phases of a motion and begins the next ones, a file each."""
