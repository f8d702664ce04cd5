"""What the thesis leaves open of its jar, fitted to some of the values that it prints."""
