/* Vectors and rotations of the plane. */
#ifndef COHAPTIC_VECTOR_H
#define COHAPTIC_VECTOR_H

typedef struct {
    double x, y;
} Vector;

/* A planar wrench (N, N, N.m), pose (m, m, rad) or velocity (m/s, m/s, rad/s). */
typedef struct {
    double x, y, theta;
} Planar;

typedef struct {
    double cosine, sine;
} Rotation;

static inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y; }
static inline double cross(Vector a, Vector b) { return a.x * b.y - a.y * b.x; }
static inline Vector plus(Vector a, Vector b) { return (Vector){a.x + b.x, a.y + b.y}; }
static inline Vector minus(Vector a, Vector b) { return (Vector){a.x - b.x, a.y - b.y}; }
static inline Vector times(double s, Vector a) { return (Vector){s * a.x, s * a.y}; }

/* A quarter turn to the left. */
static inline Vector left_of(Vector a) { return (Vector){-a.y, a.x}; }

static inline Vector turn(Rotation r, Vector a)
{
    return (Vector){r.cosine * a.x - r.sine * a.y, r.sine * a.x + r.cosine * a.y};
}

static inline Vector turn_back(Rotation r, Vector a)
{
    return (Vector){r.cosine * a.x + r.sine * a.y, r.cosine * a.y - r.sine * a.x};
}

static inline Planar planar_sum(Planar a, Planar b)
{
    return (Planar){a.x + b.x, a.y + b.y, a.theta + b.theta};
}

/* The wrench about `centre` of a force that acts at `point`. */
static inline Planar wrench_at(Vector force, Vector point, Vector centre)
{
    return (Planar){force.x, force.y, cross(minus(point, centre), force)};
}

#endif
