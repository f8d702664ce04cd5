"""The page "from a paper to your mill": the atlas in a browser."""
