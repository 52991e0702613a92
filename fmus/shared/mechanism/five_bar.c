#include "five_bar.h"

#include "cohaptic_math.h"

FiveBar five_bar(double proximal, double distal, double base)
{
    return (FiveBar){proximal, distal, base, 1.0 / distal};
}

void five_bar_pose(const FiveBar *bar, const double angle[2], FiveBarPose *pose)
{
    const Rotation joint[2] = {{cos(angle[0]), sin(angle[0])}, {cos(angle[1]), sin(angle[1])}};
    five_bar_pose_at(bar, joint, pose);
}

void five_bar_pose_at(const FiveBar *bar, const Rotation joint[2], FiveBarPose *pose)
{
    pose->valid = false;
    for (int i = 0; i < 2; i++) {
        const double c = bar->proximal * joint[i].cosine, s = bar->proximal * joint[i].sine;
        pose->elbow[i] = (Vector){(i ? bar->base : 0.0) + c, s};
        pose->tangent[i] = (Vector){-s, c};
    }
    const Vector across = minus(pose->elbow[1], pose->elbow[0]);
    const double square = dot(across, across);
    const double height = bar->distal * bar->distal - 0.25 * square;
    if (!(square > 0.0 && height > 0.0)) return;
    const double ratio = sqrt(height / square);
    const Vector reach[2] = {
        {0.5 * across.x - ratio * across.y, 0.5 * across.y + ratio * across.x},
        {-0.5 * across.x - ratio * across.y, -0.5 * across.y + ratio * across.x},
    };
    pose->tip = plus(pose->elbow[0], reach[0]);
    double drive[2];
    for (int i = 0; i < 2; i++) {
        pose->distal[i] = times(bar->inverse_distal, reach[i]);
        drive[i] = dot(pose->distal[i], pose->tangent[i]);
    }
    const Vector u = pose->distal[0], v = pose->distal[1];
    pose->cross = cross(u, v);
    if (pose->cross == 0.0) return;
    const double scale = 1.0 / pose->cross;
    pose->jacobian[0][0] = v.y * drive[0] * scale;
    pose->jacobian[0][1] = -u.y * drive[1] * scale;
    pose->jacobian[1][0] = -v.x * drive[0] * scale;
    pose->jacobian[1][1] = u.x * drive[1] * scale;
    pose->valid = true;
}

bool five_bar_angles(const FiveBar *bar, Vector tip, double angle[2])
{
    for (int i = 0; i < 2; i++) {
        const double x = tip.x - (i ? bar->base : 0.0), y = tip.y;
        const double distance = hypot(x, y);
        const double cosine = (bar->proximal * bar->proximal + distance * distance
                               - bar->distal * bar->distal)
                              / (2.0 * bar->proximal * distance);
        if (!(cosine > -1.0 && cosine < 1.0)) return false;
        const double opening = acos(cosine);
        angle[i] = atan2(y, x) + (i ? -opening : opening);
    }
    return true;
}

bool five_bar_is_regular(const double jacobian[2][2], double limit)
{
    /* The ratio r obeys r + 1/r = |J|^2 / |det J|, with the Frobenius norm. */
    const double a = jacobian[0][0], b = jacobian[0][1], c = jacobian[1][0], d = jacobian[1][1];
    return a * a + b * b + c * c + d * d <= fabs(a * d - b * c) * (limit + 1.0 / limit);
}

Vector five_bar_bias_acceleration(const FiveBar *bar, const FiveBarPose *pose,
                                  const double rate[2], Vector tip_velocity)
{
    /* u_i . xddot = u_i . Eddot_i - |xdot - Edot_i|^2 / L, with Eddot_i = -thetadot^2 (E_i - O_i). */
    double right[2];
    for (int i = 0; i < 2; i++) {
        const Vector w = pose->tangent[i], u = pose->distal[i];
        const Vector relative = minus(tip_velocity, times(rate[i], w));
        const double inward = -rate[i] * rate[i];
        right[i] = inward * cross(u, w) - dot(relative, relative) * bar->inverse_distal;
    }
    const Vector u = pose->distal[0], v = pose->distal[1];
    const double scale = 1.0 / pose->cross;
    return (Vector){(v.y * right[0] - u.y * right[1]) * scale,
                    (u.x * right[1] - v.x * right[0]) * scale};
}

Placement placement(double x, double y, double angle)
{
    return (Placement){{x, y}, {cos(angle), sin(angle)}};
}

Vector to_world(const Placement *place, Vector point)
{
    return plus(place->origin, turn(place->rotation, point));
}

Vector to_device(const Placement *place, Vector point)
{
    return turn_back(place->rotation, minus(point, place->origin));
}
