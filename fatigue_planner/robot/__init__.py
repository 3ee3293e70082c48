"""The robot arm that presents the object: where it reaches, how, and how near it comes to the worker."""
