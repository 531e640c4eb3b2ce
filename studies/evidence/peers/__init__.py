"""What others would do: the same problems by meshes, solvers and packages off the shelf, measured alike."""
