#include "lattice.h"

#include "cohaptic_math.h"

static double size_of(Vector v) { return hypot(v.x, v.y); }

static Vector rest_arm(const Lattice *lattice, int node)
{
    return (Vector){lattice->spacing * (node % LATTICE_WIDTH - 1),
                    lattice->spacing * (node / LATTICE_WIDTH - 1)};
}

static double mass_of(const Lattice *lattice, int node)
{
    return node == LATTICE_NODES / 2 ? lattice->middle : lattice->outer;
}

static double whole_mass(const Lattice *lattice)
{
    return LATTICE_OUTLINE * lattice->outer + lattice->middle;
}

bool lattice_weigh(Lattice *lattice, double mass, double inertia)
{
    lattice->outer = inertia / (12.0 * lattice->spacing * lattice->spacing);
    lattice->middle = mass - LATTICE_OUTLINE * lattice->outer;
    return lattice->middle > 0.0;
}

/* A spring holds both its nodes at most as if each were held alone, twice as stiffly: the directions of a
 * corner's three springs add up to 2, of an edge's five to 3, of the middle's eight to 4. */
bool lattice_is_stable(const Lattice *lattice, double stiffness, double damping, double period)
{
    const double own = period * period * lattice->stiffness + 2.0 * period * lattice->damping;
    const double outside = period * period * stiffness + 2.0 * period * damping;
    return 6.0 * own + outside <= 4.0 * lattice->outer && 8.0 * own <= 4.0 * lattice->middle;
}

LatticeState lattice_at(const Lattice *lattice, Planar pose)
{
    LatticeState state = {0};
    const Rotation rotation = {cos(pose.theta), sin(pose.theta)};
    for (int i = 0; i < LATTICE_NODES; i++)
        state.position[i] =
            plus((Vector){pose.x, pose.y}, turn(rotation, rest_arm(lattice, i)));
    return state;
}

BoxState lattice_mean(const Lattice *lattice, const LatticeState *state)
{
    BoxState mean = {0};
    const double whole = whole_mass(lattice);
    for (int i = 0; i < LATTICE_NODES; i++) {
        const double share = mass_of(lattice, i) / whole;
        mean.pose.x += share * state->position[i].x;
        mean.pose.y += share * state->position[i].y;
        mean.velocity.x += share * state->velocity[i].x;
        mean.velocity.y += share * state->velocity[i].y;
    }
    double along = 0.0, across = 0.0, inertia = 0.0, momentum = 0.0;
    for (int i = 0; i < LATTICE_NODES; i++) {
        const double mass = mass_of(lattice, i);
        const Vector rest = rest_arm(lattice, i);
        const Vector arm = minus(state->position[i], (Vector){mean.pose.x, mean.pose.y});
        along += mass * dot(rest, arm);
        across += mass * cross(rest, arm);
        inertia += mass * dot(arm, arm);
        momentum += mass * cross(arm, state->velocity[i]);
    }
    mean.pose.theta = atan2(across, along);
    mean.velocity.theta = inertia > 0.0 ? momentum / inertia : 0.0;
    return mean;
}

/* The three nodes of side 1 .. 4 (+x, +y, -x, -y), a quarter turn to the left of the normal. */
static const int SIDE[4][3] = {{2, 5, 8}, {8, 7, 6}, {6, 3, 0}, {0, 1, 2}};

/* Against one side: through the segment that lies before the point. */
static Touch touch_side(const Lattice *lattice, const LatticeState *state, int side, Vector point,
                        Vector velocity, LatticeGrip *grip)
{
    const int *node = SIDE[side];
    const Vector chord = minus(state->position[node[2]], state->position[node[0]]);
    const int half = dot(minus(point, state->position[node[1]]), chord) < 0.0 ? 0 : 1;
    grip->first = node[half];
    grip->second = node[half + 1];
    const Vector start = state->position[grip->first];
    const Vector edge = minus(state->position[grip->second], start);
    const double length = size_of(edge);
    const Vector tangent = times(1.0 / length, edge);
    grip->normal = (Vector){tangent.y, -tangent.x};
    const Vector arm = minus(point, start);
    grip->share = fmax(0.0, fmin(1.0, dot(arm, tangent) / length));
    const Vector material = plus(times(1.0 - grip->share, state->velocity[grip->first]),
                                 times(grip->share, state->velocity[grip->second]));
    const Vector relative = minus(velocity, material);
    const double depth = -dot(arm, grip->normal);
    return (Touch){depth > 0.0,
                   side + 1,
                   depth,
                   lattice->spacing * (half - 1 + grip->share),
                   dot(relative, grip->normal),
                   dot(relative, tangent)};
}

Touch lattice_touch(const Lattice *lattice, const LatticeState *state, const Contact *contact,
                    Vector point, Vector velocity, LatticeGrip *grip)
{
    Touch best = {.touching = false};
    for (int side = 0; side < 4; side++) {
        LatticeGrip seen;
        const Touch touch = touch_side(lattice, state, side, point, velocity, &seen);
        if (!touch.touching) return (Touch){.touching = false};
        const bool kept = contact->mode != CONTACT_FREE;
        if (kept ? contact->face == side + 1 : side == 0 || touch.depth < best.depth) {
            best = touch;
            *grip = seen;
        }
    }
    return best;
}

int lattice_outline(int i) { return i < 4 ? i : i + 1; }

void lattice_push(const LatticeGrip *grip, Vector force, Vector nodes[LATTICE_NODES])
{
    nodes[grip->first] = plus(nodes[grip->first], times(1.0 - grip->share, force));
    nodes[grip->second] = plus(nodes[grip->second], times(grip->share, force));
}

void lattice_spread(const Lattice *lattice, const LatticeState *state, Planar centre, Planar wrench,
                    Vector nodes[LATTICE_NODES])
{
    Vector arm[LATTICE_NODES];
    const double whole = whole_mass(lattice);
    double inertia = 0.0;
    for (int i = 0; i < LATTICE_NODES; i++) {
        arm[i] = minus(state->position[i], (Vector){centre.x, centre.y});
        inertia += mass_of(lattice, i) * dot(arm[i], arm[i]);
    }
    const Vector pushed = {wrench.x / whole, wrench.y / whole};
    for (int i = 0; i < LATTICE_NODES; i++) {
        const Vector faster = plus(pushed, times(wrench.theta / inertia, left_of(arm[i])));
        nodes[i] = plus(nodes[i], times(mass_of(lattice, i), faster));
    }
}

static void spring(const Lattice *lattice, const LatticeState *state, int a, int b, double rest,
                   Vector force[LATTICE_NODES])
{
    const Vector apart = minus(state->position[b], state->position[a]);
    const double length = size_of(apart);
    if (!(length > 0.0)) return;
    const Vector along = times(1.0 / length, apart);
    const double rate = dot(minus(state->velocity[b], state->velocity[a]), along);
    const Vector pull =
        times(lattice->stiffness * (length - rest) + lattice->damping * rate, along);
    force[a] = plus(force[a], pull);
    force[b] = minus(force[b], pull);
}

void lattice_step(const Lattice *lattice, LatticeState *state, const Vector outer[LATTICE_NODES],
                  double period)
{
    Vector force[LATTICE_NODES];
    for (int i = 0; i < LATTICE_NODES; i++) force[i] = outer[i];
    const double edge = lattice->spacing, diagonal = edge * sqrt(2.0);
    for (int row = 0; row < LATTICE_WIDTH; row++)
        for (int column = 0; column < LATTICE_WIDTH; column++) {
            const int i = row * LATTICE_WIDTH + column;
            const bool right = column + 1 < LATTICE_WIDTH, above = row + 1 < LATTICE_WIDTH;
            if (right) spring(lattice, state, i, i + 1, edge, force);
            if (above) spring(lattice, state, i, i + LATTICE_WIDTH, edge, force);
            if (right && above) spring(lattice, state, i, i + LATTICE_WIDTH + 1, diagonal, force);
            if (column > 0 && above)
                spring(lattice, state, i, i + LATTICE_WIDTH - 1, diagonal, force);
        }
    const double lost = period * lattice->ground_friction;
    for (int i = 0; i < LATTICE_NODES; i++) {
        const Vector after =
            plus(state->velocity[i], times(period / mass_of(lattice, i), force[i]));
        const double speed = size_of(after);
        state->velocity[i] = times(speed > lost ? 1.0 - lost / speed : 0.0, after);
        state->position[i] = plus(state->position[i], times(period, state->velocity[i]));
    }
}
