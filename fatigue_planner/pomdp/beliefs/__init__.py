"""What is known of the state: the kinds of beliefs, a file each."""
