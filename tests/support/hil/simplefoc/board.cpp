/* The sketch, with its board of memory cells, as a library: see SimpleFOC.h beside it. */
#include "SimpleFOC.h"

Board board;
SerialPort Serial;
MagneticSensorSPIConfig_s AS5147_SPI;

#include SKETCH

extern "C" Board *sketch_board() { return &board; }
extern "C" void sketch_setup() { setup(); }
extern "C" void sketch_loop() { loop(); }
