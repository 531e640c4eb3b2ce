"""What a reader of an answer must know: effects that the model leaves out, their sizes, warnings."""
