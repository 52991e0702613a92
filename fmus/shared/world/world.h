/* The shared environment as one workstation sees it: the box or its soft twin, the fingers on
 * it, the walls, and the couplings to other workstations' copies of the box. Section 7.2 of the thesis; for the couplings
 * its figure 4.2 and the wrench balance in the models' README files.
 */
#ifndef COHAPTIC_WORLD_H
#define COHAPTIC_WORLD_H

#include "box.h"
#include "contact.h"
#include "lattice.h"
#include "port.h"
#include "vector.h"

enum { OWN_FINGERS = 2, PEERS = 3, PEER_FINGERS = 2, WALLS = 4, CORNERS = 4,
       WALL_POINTS = LATTICE_OUTLINE };

typedef struct {
    bool enabled;
    Vector point, normal; /* the normal points into the free half-plane */
    Surface surface;
} Wall;

typedef struct {
    double stiffness, damping;                       /* K_o, B_o */
    double rotational_stiffness, rotational_damping; /* K_oR, B_oR */
    double force_limit, torque_limit;                /* 0: none */
} Coupling;

typedef struct {
    Box box;
    bool soft; /* the lattice takes the box's place */
    Lattice lattice;
    Surface own_surface, peer_surface; /* K_11 and K_12 */
    Wall wall[WALLS];
    Coupling coupling;
    Planar compensation; /* b_c: force -b_c times own velocity; negative cancels damping */
    Cancellation cancellation[OWN_FINGERS];
    double own_limit[OWN_FINGERS]; /* N that the box is pushed with at most; 0: none */
    double period;
} World;

typedef struct {
    BoxState box; /* with a lattice: its mean */
    LatticeState lattice;
    Contact own[OWN_FINGERS];
    Contact peer[PEERS][PEER_FINGERS];
    Contact wall[WALLS][WALL_POINTS];
    Port peer_port[PEERS][PEER_FINGERS]; /* where fingers of others come in from the network */
    Port coupling_port[PEERS];           /* where their copies of the box do */
} WorldState;

typedef struct {
    bool present;
    Vector position, velocity;
} FingerInput;

typedef struct {
    double weight;      /* scales everything that comes from this peer */
    bool coupled;       /* whether it has a copy of the box */
    BoxState box;
    FingerInput finger[PEER_FINGERS];
} PeerInput;

typedef struct {
    FingerInput own[OWN_FINGERS];
    PeerInput peer[PEERS];
} WorldInput;

typedef struct {
    Vector force; /* on the finger, in the world */
    ContactForce along; /* the same along the surface's n and t */
} FingerForce;

typedef struct {
    FingerForce own[OWN_FINGERS];
    FingerForce peer[PEERS][PEER_FINGERS];
    Planar from_own, from_peers, from_walls, total; /* on the box */
    double wall_penetration; /* deepest point, m */
    Contact own_contact[OWN_FINGERS];
    Contact peer_contact[PEERS][PEER_FINGERS];
    Port peer_port[PEERS][PEER_FINGERS];
    Port coupling_port[PEERS];
    Vector node[LATTICE_NODES]; /* outer forces on the lattice */
} WorldForces;

/* Put the object at a pose, at rest. */
void world_place(const World *world, WorldState *state, Planar pose);

/* All forces at this tick, and the fingers' contacts as they will be committed (those of the walls are
 * found again then: the struct lives on small stacks). Pure. */
void world_forces(const World *world, const WorldState *state, const WorldInput *input,
                  WorldForces *forces);

/* Commit one tick under these forces. */
void world_step(const World *world, WorldState *state, const WorldForces *forces);

#endif
