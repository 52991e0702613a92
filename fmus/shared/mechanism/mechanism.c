#include "mechanism.h"

#include "cohaptic_math.h"

typedef struct {
    double a, b, d; /* [a b; b d], symmetric */
} Symmetric;

/* A distal link's energy in the velocities of its two ends. They differ across the link only, so
 * that its spin is |xdot - Edot| / L and
 *   m |xdot + Edot|^2 / 8 + I |xdot - Edot|^2 / (2 L^2) = near (|xdot|^2 + |Edot|^2) / 2 + far xdot . Edot
 */
typedef struct {
    double near, far;
} LinkMass;

static LinkMass link_mass(const Mechanism *m)
{
    const double centre = 0.25 * m->distal_mass;
    const double spin = m->distal_inertia * m->bar.inverse_distal * m->bar.inverse_distal;
    return (LinkMass){centre + spin, centre - spin};
}

static Symmetric mass_matrix(const Mechanism *m, const FiveBarPose *pose)
{
    const LinkMass link = link_mass(m);
    const double tip = m->end_mass + 2.0 * link.near;
    const double joint = m->joint_inertia + link.near * m->bar.proximal * m->bar.proximal;
    const Vector j1 = {pose->jacobian[0][0], pose->jacobian[1][0]};
    const Vector j2 = {pose->jacobian[0][1], pose->jacobian[1][1]};
    const Vector *w = pose->tangent;
    return (Symmetric){joint + tip * dot(j1, j1) + 2.0 * link.far * dot(j1, w[0]),
                       tip * dot(j1, j2) + link.far * (dot(j2, w[0]) + dot(j1, w[1])),
                       joint + tip * dot(j2, j2) + 2.0 * link.far * dot(j2, w[1])};
}

/* c(theta, thetadot), N.m. */
static void bias_torque(const Mechanism *m, const FiveBarPose *pose, const double rate[2], double c[2])
{
    const LinkMass link = link_mass(m);
    const double mass = m->end_mass + 2.0 * link.near;
    const Vector *w = pose->tangent;
    const Vector velocity = {pose->jacobian[0][0] * rate[0] + pose->jacobian[0][1] * rate[1],
                             pose->jacobian[1][0] * rate[0] + pose->jacobian[1][1] * rate[1]};
    const Vector tip = five_bar_bias_acceleration(&m->bar, pose, rate, velocity);
    const double square[2] = {rate[0] * rate[0], rate[1] * rate[1]};
    /* The elbows' accelerations are -thetadot^2 (E_i - O_i) = thetadot^2 (-w_y, w_x). */
    const Vector force = {mass * tip.x - link.far * (square[0] * w[0].y + square[1] * w[1].y),
                          mass * tip.y + link.far * (square[0] * w[0].x + square[1] * w[1].x)};
    for (int i = 0; i < 2; i++)
        c[i] = pose->jacobian[0][i] * force.x + pose->jacobian[1][i] * force.y
               + link.far * dot(w[i], tip);
}

static double stop_torque(const Mechanism *m, int i, double angle, double rate)
{
    const double below = m->minimum[i] - angle, above = angle - m->maximum[i];
    if (below > 0.0) return fmax(m->stop_stiffness * below - m->stop_damping * rate, 0.0);
    if (above > 0.0) return fmin(-m->stop_stiffness * above - m->stop_damping * rate, 0.0);
    return 0.0;
}

/* Joint acceleration of everything smooth; also hands out M for the friction impulse. */
static bool acceleration(const Mechanism *m, const double angle[2], const Rotation joint[2],
                         const double rate[2], const double torque[2], Vector force,
                         double result[2], Symmetric *mass)
{
    FiveBarPose pose;
    five_bar_pose_at(&m->bar, joint, &pose);
    if (!pose.valid) return false;
    double c[2], net[2];
    bias_torque(m, &pose, rate, c);
    for (int i = 0; i < 2; i++)
        net[i] = torque[i] + pose.jacobian[0][i] * force.x + pose.jacobian[1][i] * force.y - c[i]
                 - m->viscous * rate[i] + stop_torque(m, i, angle[i], rate[i]);
    *mass = mass_matrix(m, &pose);
    const double scale = 1.0 / (mass->a * mass->d - mass->b * mass->b);
    result[0] = (mass->d * net[0] - mass->b * net[1]) * scale;
    result[1] = (mass->a * net[1] - mass->b * net[0]) * scale;
    return true;
}

static double clamp(double value, double limit) { return fmax(-limit, fmin(limit, value)); }

/* Coulomb friction over one sub-step: the impulse p, |p_i| <= limit, after which each joint either
 * stands still or slides against its full friction. M is positive definite, so exactly one such p
 * exists; it is found by looking at the few possible cases. */
static void friction_impulse(const Symmetric *mass, double limit, double rate[2])
{
    const double hold[2] = {-(mass->a * rate[0] + mass->b * rate[1]),
                            -(mass->b * rate[0] + mass->d * rate[1])};
    if (fabs(hold[0]) <= limit && fabs(hold[1]) <= limit) {
        rate[0] = rate[1] = 0.0;
        return;
    }
    const double scale = 1.0 / (mass->a * mass->d - mass->b * mass->b);
    const double own[2] = {mass->d * scale, mass->a * scale}, cross = -mass->b * scale;
    double best[2] = {rate[0], rate[1]}, least = INFINITY;
    for (int i = 0; i < 2; i++) {
        const int j = 1 - i;
        for (int side = -1; side <= 1; side += 2) {
            const double impulse = side * limit;
            const double wanted = -(rate[j] + cross * impulse) / own[j];
            const double other = clamp(wanted, limit);
            double after[2];
            after[i] = rate[i] + own[i] * impulse + cross * other;
            after[j] = other == wanted ? 0.0 : rate[j] + cross * impulse + own[j] * other;
            const double violation = fmax(side * after[i], 0.0);
            if (violation < least) {
                least = violation;
                best[0] = after[0];
                best[1] = after[1];
            }
        }
    }
    rate[0] = best[0];
    rate[1] = best[1];
}

double mechanism_energy(const Mechanism *m, const FiveBarPose *pose, const double rate[2])
{
    const Symmetric mass = mass_matrix(m, pose);
    return 0.5 * (mass.a * rate[0] * rate[0] + mass.d * rate[1] * rate[1])
           + mass.b * rate[0] * rate[1];
}

/* The rotation turned on by an angle. Sub-steps turn the joints by hundredths of a radian at most,
 * where the series to the ninth power is exact to the last bit but one, and cheaper than sin and cos. */
static Rotation turned(Rotation r, double angle)
{
    const double q = angle * angle;
    if (!(q < 1e-2)) return (Rotation){r.cosine * cos(angle) - r.sine * sin(angle),
                                            r.sine * cos(angle) + r.cosine * sin(angle)};
    const double c = 1.0 - q * (1.0 / 2 - q * (1.0 / 24 - q * (1.0 / 720 - q * (1.0 / 40320))));
    const double s =
        angle * (1.0 - q * (1.0 / 6 - q * (1.0 / 120 - q * (1.0 / 5040 - q * (1.0 / 362880)))));
    return (Rotation){r.cosine * c - r.sine * s, r.sine * c + r.cosine * s};
}

void mechanism_joints(const MechanismState *state, Rotation joint[2])
{
    for (int i = 0; i < 2; i++) joint[i] = (Rotation){cos(state->angle[i]), sin(state->angle[i])};
}

bool mechanism_step(const Mechanism *m, MechanismState *s, Rotation joint[2],
                    const double start[2], const double middle[2], Vector force, double h)
{
    double slope[2], angle[2], rate[2];
    Rotation half_way[2];
    Symmetric mass;
    if (!acceleration(m, s->angle, joint, s->rate, start, force, slope, &mass)) return false;
    for (int i = 0; i < 2; i++) {
        const double turn = 0.5 * h * s->rate[i];
        angle[i] = s->angle[i] + turn;
        half_way[i] = turned(joint[i], turn);
        rate[i] = s->rate[i] + 0.5 * h * slope[i];
    }
    if (!acceleration(m, angle, half_way, rate, middle, force, slope, &mass)) return false;
    const double smooth[2] = {s->rate[0] + h * slope[0], s->rate[1] + h * slope[1]};
    double after[2] = {smooth[0], smooth[1]};
    if (m->coulomb > 0.0) friction_impulse(&mass, h * m->coulomb, after);
    for (int i = 0; i < 2; i++) {
        /* Friction acts all through the sub-step; a joint that it holds does not creep. */
        const bool held = s->rate[i] == 0.0 && after[i] == 0.0;
        const double turn = held ? 0.0 : h * (rate[i] + 0.5 * (after[i] - smooth[i]));
        s->angle[i] += turn;
        joint[i] = turned(joint[i], turn);
        s->rate[i] = after[i];
    }
    return true;
}
