"""What a user feels: admittance, damping, stiffness, and the compensation (chapter 6)."""
