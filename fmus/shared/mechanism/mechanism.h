/* Dynamics of the five-bar in its joint angles, and its fixed-step integration.
 *
 *   M(theta) thetaddot + c(theta, thetadot) = torque + J' force - viscous thetadot - Coulomb - stops
 *   M = diag(I_p + gear^2 I_r) + sum_i (m J_c' J_c + I_d phi_i' phi_i) + m_e J' J
 *
 * c follows from d'Alembert, sum J_k' m_k (Jdot_k thetadot), with every Jdot thetadot in closed form;
 * the distal links are written in the velocities of their ends (see link_mass).
 */
#ifndef COHAPTIC_MECHANISM_H
#define COHAPTIC_MECHANISM_H

#include "five_bar.h"

typedef struct {
    FiveBar bar;
    double joint_inertia;   /* proximal link and rotor at the joint, kg.m2 */
    double distal_mass, distal_inertia, end_mass;
    double viscous, coulomb;
    double minimum[2], maximum[2]; /* mechanical stops, rad */
    double stop_stiffness, stop_damping;
} Mechanism;

typedef struct {
    double angle[2], rate[2];
} MechanismState;

/* Kinetic energy, J. */
double mechanism_energy(const Mechanism *mechanism, const FiveBarPose *pose, const double rate[2]);

/* Cosines and sines of the joint angles, which mechanism_step carries from sub-step to sub-step. */
void mechanism_joints(const MechanismState *state, Rotation joint[2]);

/* One sub-step of h seconds: the explicit midpoint rule (order 2) for everything smooth, with the
 * joint torques given at the start and at the middle of the sub-step and a tip force (N, device
 * frame) held over it, and Coulomb friction as an implicit impulse (it takes energy only, holds
 * exactly and does not chatter). False where the mechanism left its assembly. */
bool mechanism_step(const Mechanism *mechanism, MechanismState *state, Rotation joint[2],
                    const double start[2], const double middle[2], Vector force, double h);

#endif
