/* Kinematics of the planar five-bar in the device's own frame: motors at (0, 0) and (d, 0).
 *
 * Closed form of the elbow-out assembly; velocities from u_i . (xdot - Edot_i) = 0, where u_i
 * points along distal link i from its elbow E_i to the tip (Campion, Wang, Hayward, "The Pantograph
 * Mk-II", IROS 2005, gives the geometry; the Jacobian here is derived from the constraint).
 */
#ifndef COHAPTIC_FIVE_BAR_H
#define COHAPTIC_FIVE_BAR_H

#include <stdbool.h>

#include "vector.h"

typedef struct {
    double proximal, distal, base; /* l, L, d in m */
    double inverse_distal;
} FiveBar;

typedef struct {
    Vector elbow[2];    /* E_i, m */
    Vector tangent[2];  /* w_i = dE_i/dtheta_i, m/rad */
    Vector distal[2];   /* u_i, unit vectors */
    Vector tip;         /* m */
    double jacobian[2][2]; /* J: tip velocity = J joint velocity, m/rad */
    double cross;       /* u_1 x u_2 */
    bool valid;         /* false where the mechanism cannot close or J does not exist */
} FiveBarPose;

FiveBar five_bar(double proximal, double distal, double base);

/* Pose at joint angles (rad). An impossible or NaN angle gives valid = false and nothing else. */
void five_bar_pose(const FiveBar *bar, const double angle[2], FiveBarPose *pose);

/* The same from the joint angles' cosines and sines. */
void five_bar_pose_at(const FiveBar *bar, const Rotation joint[2], FiveBarPose *pose);

/* Joint angles (rad) that reach a tip position (m); false where it is out of reach. */
bool five_bar_angles(const FiveBar *bar, Vector tip, double angle[2]);

/* Whether the ratio of the largest to the smallest singular value of J is at most `limit`. */
bool five_bar_is_regular(const double jacobian[2][2], double limit);

/* Tip acceleration at zero joint acceleration, Jdot thetadot, m/s2. */
Vector five_bar_bias_acceleration(const FiveBar *bar, const FiveBarPose *pose,
                                  const double rate[2], Vector tip_velocity);

/* Where a device stands in the world: SE(2). */
typedef struct {
    Vector origin;
    Rotation rotation;
} Placement;

Placement placement(double x, double y, double angle);
Vector to_world(const Placement *place, Vector point);
Vector to_device(const Placement *place, Vector point);

#endif
