"""How a worker chooses among preferences besides Eq. 4: the kinds of choice models, a file each."""
