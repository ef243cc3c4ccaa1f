"""What a diagnosis looks like: a page of HTML, TensorBoard events, lines on the terminal."""
