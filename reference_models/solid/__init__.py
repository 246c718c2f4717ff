"""Three-dimensional rods: CalculiX, NGSolve, and limbs known by tables made from them."""
