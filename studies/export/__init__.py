"""What leaves the program for others: a motor for simulators, masks, and what a lab's instruments would record."""
