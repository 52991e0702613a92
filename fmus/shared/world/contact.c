#include "contact.h"

#include "cohaptic_math.h"

static double sign(double value) { return value < 0.0 ? -1.0 : 1.0; }

/* Fix the spring where its force is -direction mu_k f_n at once, damping included: re-sticking is
 * bumpless, and a point that is pushed on slowly drags its anchor along. */
static double bumpless_anchor(const Surface *surface, const Touch *touch, double direction,
                              double normal)
{
    if (!(surface->tangential_stiffness > 0.0)) return touch->slip;
    const double spring = direction * surface->kinetic_friction * normal
                          - surface->tangential_damping * touch->tangential_velocity;
    return touch->slip - spring / surface->tangential_stiffness;
}

/* Equations (7.3) and (7.4) with the transitions between them. */
static void stick_or_slide(Contact *contact, const Surface *surface, const Touch *touch,
                           ContactForce *force)
{
    /* The damper must not pull: a leaving finger is let go. */
    force->normal = fmax(surface->normal_stiffness * touch->depth
                             - surface->normal_damping * touch->normal_velocity,
                         0.0);
    const bool fast = fabs(touch->tangential_velocity) > surface->slide_threshold;
    const double limit = surface->kinetic_friction * force->normal;
    if (contact->mode == CONTACT_SLIDE) {
        if (fast) {
            contact->direction = sign(touch->tangential_velocity);
            force->tangential = -contact->direction * limit;
            return;
        }
        contact->mode = CONTACT_PRE_SLIDE;
        contact->anchor = bumpless_anchor(surface, touch, contact->direction, force->normal);
        force->tangential = -contact->direction * limit;
        return;
    }
    force->tangential = -surface->tangential_stiffness * (touch->slip - contact->anchor)
                        - surface->tangential_damping * touch->tangential_velocity;
    if (fabs(force->tangential) <= surface->static_friction * force->normal) return;
    contact->direction = fast ? sign(touch->tangential_velocity) : -sign(force->tangential);
    force->tangential = -contact->direction * limit;
    if (fast)
        contact->mode = CONTACT_SLIDE;
    else
        contact->anchor = bumpless_anchor(surface, touch, contact->direction, force->normal);
}

/* N = floor(m_h v_c / (T_c F_max)), eq. (7.2); the cap is a minute of impulses at 1024 Hz. */
static int64_t impulse_count(const Cancellation *cancellation, double approach)
{
    if (!(cancellation->largest_force > 0.0 && approach > 0.0)) return 0;
    return (int64_t)fmin(floor(cancellation->hand_mass * approach
                               / (cancellation->period * cancellation->largest_force)),
                         61440.0);
}

Contact contact_next(const Contact *before, const Surface *surface, const Touch *touch,
                     const Cancellation *cancellation, ContactForce *force)
{
    Contact contact = *before;
    *force = (ContactForce){0.0, 0.0};
    if (!touch->touching) {
        if (contact.mode == CONTACT_FREE) return contact;
        return (Contact){.losses = contact.losses + 1};
    }
    if (contact.mode == CONTACT_FREE) {
        contact.mode = CONTACT_MOMENT_CANCELLATION;
        contact.face = touch->face;
        contact.impulses = impulse_count(cancellation, -touch->normal_velocity);
    }
    if (contact.mode == CONTACT_MOMENT_CANCELLATION) {
        if (contact.impulses > 0 && touch->normal_velocity < 0.0) {
            contact.impulses--;
            force->normal = cancellation->largest_force;
            return contact;
        }
        contact.mode = CONTACT_PRE_SLIDE;
        contact.impulses = 0;
        contact.anchor = touch->slip;
    }
    stick_or_slide(&contact, surface, touch, force);
    return contact;
}
