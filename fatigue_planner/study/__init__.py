"""What a researcher does with experiments: benchmark, statistics, claims and sensitivity studies."""
