"""What every page is made of: sections of blocks, and the template that shows them."""
