/* One contact point on one frictional surface: the four-state machine of section 7.2.2 of the thesis.
 *
 *   free -> moment_cancellation -> pre_slide <-> slide -> free
 *
 * One machine serves a finger on the box and a corner of the box on a wall. Forces act on the body
 * that owns the point: `normal` along the surface's outward normal n, `tangential` along t, a
 * quarter turn to the left of n.
 */
#ifndef COHAPTIC_CONTACT_H
#define COHAPTIC_CONTACT_H

#include <stdbool.h>
#include <stdint.h>

enum { CONTACT_FREE, CONTACT_MOMENT_CANCELLATION, CONTACT_PRE_SLIDE, CONTACT_SLIDE };

typedef struct {
    double normal_stiffness, normal_damping;         /* N/m, N.s/m */
    double tangential_stiffness, tangential_damping; /* N/m, N.s/m */
    double static_friction, kinetic_friction;
    double slide_threshold;                          /* v_tr, m/s */
} Surface;

/* Committed from one tick to the next. */
typedef struct {
    int64_t mode;
    int64_t face;      /* 0: none; kept from entry to exit */
    int64_t impulses;  /* still to be given */
    int64_t losses;    /* how often the contact has ended */
    double anchor;     /* where the tangential spring is fixed, m along t */
    double direction;  /* of the last slide along t, +1 or -1 */
} Contact;

/* Where the point is against the surface, and how it moves relative to the surface's material. */
typedef struct {
    bool touching;
    int64_t face;
    double depth;               /* penetration, m */
    double slip;                /* coordinate along t, m */
    double normal_velocity;     /* along n: negative on approach, m/s */
    double tangential_velocity; /* along t, m/s */
} Touch;

/* The impulses that take the hand's momentum (7.1, 7.2); largest_force 0 switches them off. */
typedef struct {
    double hand_mass, largest_force, period;
} Cancellation;

typedef struct {
    double normal, tangential;
} ContactForce;

/* The contact at this tick and its force, from the contact at the tick before. Pure. */
Contact contact_next(const Contact *before, const Surface *surface, const Touch *touch,
                     const Cancellation *cancellation, ContactForce *force);

#endif
