/* What the sketch uses of Arduino and SimpleFOC, for a run on this machine: a board of memory cells. */
#pragma once
#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define _2PI 6.28318530718f
#define _constrain(value, low, high) ((value) < (low) ? (low) : (value) > (high) ? (high) : (value))
enum { LOW = 0, HIGH = 1, INPUT_PULLUP = 2 };
enum class TorqueControlType { voltage, foc_current };
enum class MotionControlType { torque };

struct Board {
    uint32_t micros;
    float angle[2];
    float current[2];
    int enabled[2];
    uint8_t in[4096], out[4096];
    int in_size, in_place, out_size;
    int sensors, motors, drivers;
};
extern Board board;

inline uint32_t micros() { return board.micros; }
inline void pinMode(int, int) {}
inline int digitalRead(int) { return HIGH; }

struct SerialPort {
    void begin(long) {}
    int available() { return board.in_size - board.in_place; }
    int read() { return board.in[board.in_place++]; }
    void write(const uint8_t *data, size_t size) {
        for (size_t i = 0; i < size; i++) board.out[board.out_size++] = data[i];
    }
};
extern SerialPort Serial;

struct MagneticSensorSPIConfig_s {};
extern MagneticSensorSPIConfig_s AS5147_SPI;
struct MagneticSensorSPI {
    int index;
    MagneticSensorSPI(MagneticSensorSPIConfig_s, int) : index(board.sensors++) {}
    void init() {}
    float getAngle() { return board.angle[index]; }
};
struct BLDCDriver3PWM {
    float voltage_power_supply;
    BLDCDriver3PWM(int, int, int, int) {}
    void init() {}
};
struct BLDCMotor {
    int index;
    TorqueControlType torque_controller;
    MotionControlType controller;
    float current_limit;
    BLDCMotor(int) : index(board.motors++) {}
    void linkSensor(MagneticSensorSPI *) {}
    void linkDriver(BLDCDriver3PWM *) {}
    void init() {}
    void initFOC() {}
    void loopFOC() {}
    void enable() { board.enabled[index] = 1; }
    void disable() { board.enabled[index] = 0; board.current[index] = 0; }
    void move(float target) { board.current[index] = board.enabled[index] ? target : 0; }
};
