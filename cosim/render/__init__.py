"""A run as moving pictures: its scene drawn frame by frame, and the frames as gif, webp or mp4."""
