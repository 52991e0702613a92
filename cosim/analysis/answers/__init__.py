"""What is asked of a run and answered from its map: margins, loss, what users feel, named modes."""
