"""The command line: the parser, and what each call does."""
