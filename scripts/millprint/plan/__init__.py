"""What a run is going to do: its jobs, and the time, memory and disk that they take, before anything runs."""
