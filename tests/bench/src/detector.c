/* The detector in plain C, in the manner of the Reference FMUs: what a careful C programmer would
 * write from method 3 and 6 by hand, with the constants of the sample path computed once. The
 * operations on the data are in the same order as in the packaged library, so that the outputs are
 * equal bit for bit.
 *
 * Value references are those of SteeringFaultDetector.fmu. Validity, range monitoring, alarms and other
 * state handling, an actuator, which the designs compared do not have, and the other FMI functions are left
 * out: they would only cost time here. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define MAX_WINDOW 256
#define GRAVITY 9.80665
#define ACCELERATION_FILTER 0.15
/* Reference motions are drawn to the measured yaw rate from this share of the critical speed on, at that
 * speed this fast. */
#define DRAWN_FROM 0.6
#define DRAW 15.0

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef enum {
    V_X, R, T_ENG, DELTA, RESIDUAL_V_X = 5, RESIDUAL_R, J_RMS, J_TH, DETECTABILITY = 15
} ValueReference;
/* Causes, in the order of the detector's: along the reference motions, wherever the vehicle is, and on the
 * measurement. */
enum { MASS, YAW_INERTIA, FRONT_STIFFNESS, REAR_STIFFNESS, FRICTION, LOAD_TRANSFER, ALONG };
enum { BANK, GUST, RATIO, OFFSET, FRONT_SIDE_FORCE, REAR_SIDE_FORCE, COMMON };
enum { BIAS, SCALE, SENSED };
enum { MOTIONS = 3 };

/* Mirrored in lib.rs. */
typedef struct {
    double mass, yaw_inertia, longitudinal_inertia, l_f, l_r, c_f, c_r, c_x, c_y, height;
    double period;
    double v_x_min, v_x_max, r_min, r_max;
    double n[4][3][3], l[4][3][2], m[3][3], e[3][2];
    double weights[2], threshold, start_up_amplitude, start_up_decay;
    double share;
    struct {
        double mass, yaw_inertia, front, rear;
        double friction; /* 0 for tyres without end */
        double load_transfer, bank, gust_speed, gust_coefficient, gust_ahead;
        double ratio, offset, bias, scale;
    } q;
    double smallest_fault[3];
    double steering_offset, yaw_rate_bias;
    size_t euler_correction, window;
} Configuration;

/* Window of squares, as in the detector: the sum of this round through the ring and that of what is left
 * of the round before. */
typedef struct {
    double ring[MAX_WINDOW], newer;
    size_t next;
} Window;

/* Lateral motion, v_y and r, and the coefficients of its single-track model. */
typedef struct {
    double x[2];
    double lateral[3], yaw[3];
} Motion;

typedef struct {
    Configuration c;
    /* Constants of the sample path. */
    double b[3][2], g_phi, drag, cross, damping, slow, fast, half_square;
    double lighter, easier, wheelbase, front_holds, rear_holds, front_lever, rear_lever, critical, factor[MOTIONS][2], lightness[MOTIONS];
    int along[ALONG], common[COMMON], sensed[SENSED], any, any_along, transfers;
    size_t motions;
    /* Inputs, states, outputs. */
    double y[2], u[2], z[3], filtered;
    double residual[2], j_rms, j_th, detectability;
    Motion motion[MOTIONS];
    double known[3], of_along[MOTIONS][ALONG][3], of_common[COMMON][3], of_sensed[SENSED][3], fault[3];
    Window j, uncertain, seen;
    double power, sum;
    size_t started;
    unsigned long long sample;
} Instance;

static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

/* 1 - tanh(x) / x by a continued fraction. */
static double deficit(double x) {
    const double square = x * x;
    const double fraction = square / (3.0 + square / (5.0 + square / 7.0));
    return fraction / (1.0 + fraction);
}

/* Side force of the gust. */
static double gust_force(const Configuration *c, double v_x) {
    const double wind = c->q.gust_speed;
    return c->q.gust_coefficient * wind * sqrt(v_x * v_x + wind * wind);
}

/* What the axles hold against bank and gust. */
static void hold_aside(const Instance *s, double v_x, double aside[2]) {
    const Configuration *c = &s->c;
    const double gust = gust_force(c, v_x), bank = c->mass * c->q.bank;
    aside[0] = (bank * c->l_r + gust * s->front_lever) / s->wheelbase;
    aside[1] = (bank * c->l_f + gust * s->rear_lever) / s->wheelbase;
}

/* Axle loads over the static ones. */
static void load_factors(const Configuration *c, double a_x, double loads[2]) {
    const double moved = a_x * c->height / GRAVITY;
    loads[0] = larger(1.0 - moved / c->l_r, 0.1);
    loads[1] = larger(1.0 + moved / c->l_f, 0.1);
}

/* What axle forces at the static loads gain and lose: lateral and yaw acceleration. */
static void transfer_load(const Configuration *c, const double force[2], double a_x, double transfer[2]) {
    const double share = a_x * c->height / GRAVITY;
    const double front = -force[0] * share / c->l_r, rear = force[1] * share / c->l_f;
    transfer[0] = (front + rear) / c->mass;
    transfer[1] = (c->l_f * front - c->l_r * rear) / c->yaw_inertia;
}

/* Axle forces of linear tyres at the static loads. */
static void axle_forces(const Configuration *c, double v_x, double v_y, double r, double delta, double force[2]) {
    force[0] = 2.0 * c->c_f * (delta - (v_y + c->l_f * r) / v_x);
    force[1] = 2.0 * c->c_r * ((c->l_r * r - v_y) / v_x);
}

/* With stiffnesses of so many times those of the configuration and the mass divided by a number. */
static void motion_load(Motion *m, const Configuration *c, double front, double rear, double lightness) {
    const double mass = c->mass / lightness;
    const double c_f = 2.0 * front * c->c_f, c_r = 2.0 * rear * c->c_r;
    const double moment = c_r * c->l_r - c_f * c->l_f;
    m->lateral[0] = -(c_f + c_r) / mass;
    m->lateral[1] = moment / mass;
    m->lateral[2] = c_f / mass;
    m->yaw[0] = moment / c->yaw_inertia;
    m->yaw[1] = -(c_f * c->l_f * c->l_f + c_r * c->l_r * c->l_r) / c->yaw_inertia;
    m->yaw[2] = c->l_f * c_f / c->yaw_inertia;
}

/* Critical speed with stiffnesses of so many times; infinite where it does not oversteer. */
static double critical_speed(const Configuration *c, double front, double rear, double lightness) {
    const double c_f = front * c->c_f, c_r = rear * c->c_r;
    const double oversteer = c_f * c->l_f - c_r * c->l_r, wheelbase = c->l_f + c->l_r;
    if (!(oversteer > 0.0)) return INFINITY;
    return sqrt(2.0 * c_f * c_r * wheelbase * wheelbase * lightness / (c->mass * oversteer));
}

/* Motions and critical speed of the worst vehicle, with stiffnesses of so many times. */
static void load_motions(Instance *s, double factor[MOTIONS][2]) {
    const Configuration *c = &s->c;
    for (int i = 0; i < MOTIONS; i++) motion_load(&s->motion[i], c, factor[i][0], factor[i][1], s->lightness[i]);
    s->critical = critical_speed(c, factor[1][0], factor[1][1], s->lightness[1]);
}

Instance *detector_new(const Configuration *c) {
    Instance *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    double t = c->period, moment = c->c_r * c->l_r - c->c_f * c->l_f;
    s->c = *c;
    s->b[0][0] = t / c->longitudinal_inertia;
    s->b[1][1] = t * 2.0 * c->c_f / c->mass;
    s->b[2][1] = t * 2.0 * c->l_f * c->c_f / c->yaw_inertia;
    s->g_phi = -t * c->c_y / c->mass;
    s->drag = -t * c->c_x;
    s->cross = 2.0 * moment;
    s->damping = -t * (2.0 * (c->c_f * c->l_f * c->l_f + c->c_r * c->l_r * c->l_r));
    s->slow = 1.0 / c->v_x_min;
    s->fast = 1.0 / c->v_x_max;
    s->power = 1.0;
    s->half_square = 0.5 * t * t;

    s->lighter = 1.0 + c->q.mass;
    s->easier = 1.0 + c->q.yaw_inertia;
    s->wheelbase = c->l_f + c->l_r;
    const double weight = c->mass * GRAVITY, front_load = weight * c->l_r / s->wheelbase;
    s->front_holds = c->q.friction * front_load;
    s->rear_holds = c->q.friction * (weight - front_load);
    s->front_lever = fabs(c->l_r + c->q.gust_ahead);
    s->rear_lever = fabs(c->l_f - c->q.gust_ahead);
    s->factor[0][0] = s->factor[0][1] = 1.0;
    s->factor[1][0] = 1.0 + c->q.front;
    s->factor[1][1] = larger(1.0 - c->q.rear, 0.1);
    s->factor[2][0] = larger(1.0 - c->q.front, 0.1);
    s->factor[2][1] = 1.0 + c->q.rear;
    s->lightness[0] = 1.0;
    s->lightness[1] = s->lightness[2] = larger(1.0 - c->q.mass, 0.1);
    load_motions(s, s->factor);
    const double uncertain = larger(larger(c->q.front, c->q.rear), larger(c->q.mass, c->q.load_transfer));
    s->motions = uncertain > 0.0 || c->q.friction > 0.0 ? MOTIONS : 1;
    s->transfers = c->height > 0.0;

    if (c->share > 0.0) {
        const int gust = c->q.gust_speed > 0.0 && c->q.gust_coefficient > 0.0;
        const int side_force = c->q.bank > 0.0 || gust;
        s->along[MASS] = c->q.mass > 0.0;
        s->along[YAW_INERTIA] = c->q.yaw_inertia > 0.0;
        s->along[FRONT_STIFFNESS] = c->q.front > 0.0;
        s->along[REAR_STIFFNESS] = c->q.rear > 0.0;
        s->along[FRICTION] = c->q.friction > 0.0;
        s->along[LOAD_TRANSFER] = s->transfers;
        s->common[BANK] = c->q.bank > 0.0;
        s->common[GUST] = gust;
        s->common[RATIO] = c->q.ratio > 0.0;
        s->common[OFFSET] = c->q.offset > 0.0;
        s->common[FRONT_SIDE_FORCE] = side_force && (c->q.front > 0.0 || s->transfers);
        s->common[REAR_SIDE_FORCE] = side_force && (c->q.rear > 0.0 || s->transfers);
        s->sensed[BIAS] = c->q.bias > 0.0;
        s->sensed[SCALE] = c->q.scale > 0.0;
    }
    for (int k = 0; k < ALONG; k++) s->any_along |= s->along[k];
    s->any = s->any_along;
    for (int k = 0; k < COMMON; k++) s->any |= s->common[k];
    for (int k = 0; k < SENSED; k++) s->any |= s->sensed[k];
    return s;
}

void detector_free(Instance *s) { free(s); }

static double push(Window *w, double square, size_t window) {
    double sum;
    w->ring[w->next] = square;
    w->next++;
    w->newer += square;
    if (w->next < window) {
        sum = w->newer + w->ring[w->next];
    } else {
        double older = 0.0;
        for (size_t i = window; i-- > 0;) {
            older += w->ring[i];
            w->ring[i] = older;
        }
        w->next = 0;
        sum = w->newer;
        w->newer = 0.0;
    }
    return sqrt(sum / (double)window);
}

/* ||W_r C e||^2 of a residual. */
static double square(const Configuration *c, double v_x, double r) {
    const double a = c->weights[0] * v_x, b = c->weights[1] * r;
    return a * a + b * b;
}

/* ||W_r C e||. */
static double size(const Configuration *c, const double e[3]) { return sqrt(square(c, e[0], e[2])); }

/* e+ = N e + M w. */
static void respond(double n[3][3], double m[3][3], double e[3], const double w[3]) {
    double next[3];
    for (int i = 0; i < 3; i++)
        next[i] = (0.0 + n[i][0] * e[0] + n[i][1] * e[1] + n[i][2] * e[2])
            + (0.0 + m[i][0] * w[0] + m[i][1] * w[1] + m[i][2] * w[2]);
    for (int i = 0; i < 3; i++) e[i] = next[i];
}

/* The same over a period, of a slope. */
static void respond_to(const Instance *s, double n[3][3], double held[3][3], double e[3], double x, double y, double z) {
    const double w[3] = {s->c.period * x, s->c.period * y, s->c.period * z};
    respond(n, held, e, w);
}

/* The same, of axle forces on the lightest vehicle with the least yaw inertia. */
static void respond_to_forces(const Instance *s, double n[3][3], double held[3][3], double e[3], double front, double rear) {
    const Configuration *c = &s->c;
    const double y = s->lighter * (front + rear) / c->mass;
    const double z = s->easier * (c->l_f * front - c->l_r * rear) / c->yaw_inertia;
    respond_to(s, n, held, e, 0.0, y, z);
}

/* What the measurement's error of a cause adds to [v_x, r]. */
static void error_of(const Configuration *c, int cause, double v_x, double error[2]) {
    error[0] = cause == SCALE ? c->q.scale * v_x : 0.0;
    error[1] = cause == BIAS ? c->q.bias : 0.0;
}

/* What the uncertainties add to ||W_r r|| at most. */
static double bound(const Instance *s, double v_x) {
    const Configuration *c = &s->c;
    double largest = 0.0, common = 0.0, sum;
    if (s->any_along) {
        for (size_t i = 0; i < s->motions; i++) {
            double along = 0.0;
            for (int k = 0; k < ALONG; k++)
                if (s->along[k]) along += size(c, s->of_along[i][k]);
            largest = larger(largest, along);
        }
    }
    for (int k = 0; k < COMMON; k++)
        if (s->common[k]) common += size(c, s->of_common[k]);
    sum = largest + common;
    for (int k = 0; k < SENSED; k++) {
        if (!s->sensed[k]) continue;
        const double *e = s->of_sensed[k];
        double error[2];
        error_of(c, k, v_x, error);
        const double seen[3] = {
            e[0] + ((0.0 + c->e[0][0] * error[0] + c->e[0][1] * error[1]) + error[0]),
            0.0,
            e[2] + ((0.0 + c->e[2][0] * error[0] + c->e[2][1] * error[1]) + error[1]),
        };
        sum += size(c, seen);
    }
    return sum;
}

/* Responses to what is known, to what is uncertain and to the smallest fault: method 6. */
static void advance_responses(Instance *s, double n[3][3], double l[3][2], double v_x, double v_y, double r, double delta, double a_x, double asked,
                              const double aside[2]) {
    const Configuration *c = &s->c;
    const double t_eng = s->u[0], period = c->period;
    /* Jacobian of (3). */
    const double by_front = -2.0 * c->c_f / v_x, by_rear = -2.0 * c->c_r / v_x;
    const double front_by_v_x = -by_front * (v_y + c->l_f * r) / v_x;
    const double rear_by_v_x = -by_rear * (v_y - c->l_r * r) / v_x;
    const double by_moment = c->l_f * by_front - c->l_r * by_rear;
    const double jacobian[3][3] = {
        {-2.0 * c->c_x * v_x / c->longitudinal_inertia, r, v_y},
        {(front_by_v_x + rear_by_v_x) / c->mass - r, (by_front + by_rear - 2.0 * c->c_y * v_y) / c->mass, by_moment / c->mass - v_x},
        {(c->l_f * front_by_v_x - c->l_r * rear_by_v_x) / c->yaw_inertia, by_moment / c->yaw_inertia,
         (c->l_f * c->l_f * by_front + c->l_r * c->l_r * by_rear) / c->yaw_inertia},
    };
    /* M (I + T_s J / 2): second-order hold. */
    double held[3][3];
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) held[i][k] = c->m[i][k];
        if (c->euler_correction)
            for (int j = 0; j < 3; j++)
                for (int k = 0; k < 3; k++) held[i][k] += 0.5 * period * c->m[i][j] * jacobian[j][k];
    }
    respond(n, held, s->fault, c->smallest_fault);

    double force[2], modelled[2], transfer[2] = {0.0, 0.0};
    axle_forces(c, v_x, v_y, r, delta, force);
    axle_forces(c, v_x, s->motion[0].x[0], s->motion[0].x[1], delta, modelled);
    if (s->transfers) transfer_load(c, modelled, a_x, transfer);
    if (c->euler_correction) {
        const double slope[3] = {
            (t_eng - c->c_x * v_x * v_x) / c->longitudinal_inertia + v_y * r,
            (force[0] + force[1] - c->c_y * v_y * v_y) / c->mass - v_x * r,
            (c->l_f * force[0] - c->l_r * force[1]) / c->yaw_inertia,
        };
        const double w[3] = {0.0, period * transfer[0], period * transfer[1]};
        double remainder[3];
        for (int i = 0; i < 3; i++)
            remainder[i] = s->half_square * (0.0 + jacobian[i][0] * slope[0] + jacobian[i][1] * slope[1] + jacobian[i][2] * slope[2]);
        respond(n, s->c.m, s->known, remainder);
        for (int i = 0; i < 3; i++)
            s->known[i] += 0.0 + held[i][0] * w[0] + held[i][1] * w[1] + held[i][2] * w[2];
    } else if (s->transfers) {
        respond_to(s, n, held, s->known, 0.0, transfer[0], transfer[1]);
    }
    if (!s->any) return;

    double loads[2];
    load_factors(c, a_x, loads);
    const double unknown = c->q.load_transfer * fabs(a_x) + fabs(asked - a_x), along_it = a_x < 0.0 ? -unknown : unknown;
    for (size_t i = 0; s->any_along && i < s->motions; i++) {
        const double *x = s->motion[i].x;
        double(*e)[3] = s->of_along[i];
        double at_rest[2];
        axle_forces(c, v_x, x[0], x[1], delta, at_rest);
        const double f = at_rest[0] * loads[0], b = at_rest[1] * loads[1];
        if (s->along[MASS])
            respond_to(s, n, held, e[MASS], c->q.mass * asked, c->q.mass * (f + b - c->c_y * x[0] * x[0]) / c->mass, 0.0);
        if (s->along[YAW_INERTIA])
            respond_to(s, n, held, e[YAW_INERTIA], 0.0, 0.0, c->q.yaw_inertia * (c->l_f * f - c->l_r * b) / c->yaw_inertia);
        if (s->along[FRONT_STIFFNESS]) respond_to_forces(s, n, held, e[FRONT_STIFFNESS], c->q.front * f, 0.0);
        if (s->along[REAR_STIFFNESS]) respond_to_forces(s, n, held, e[REAR_STIFFNESS], 0.0, c->q.rear * b);
        if (s->along[FRICTION]) {
            const double front = fabs(at_rest[0]) + aside[0], rear = fabs(at_rest[1]) + aside[1];
            const double front_missing = front * deficit(front / s->front_holds);
            const double rear_missing = rear * deficit(rear / s->rear_holds);
            respond_to_forces(s, n, held, e[FRICTION], -(loads[0] * (at_rest[0] > 0.0 ? front_missing : -front_missing)),
                              -(loads[1] * (at_rest[1] > 0.0 ? rear_missing : -rear_missing)));
        }
        if (s->along[LOAD_TRANSFER]) {
            const double elsewhere[2] = {at_rest[0] - modelled[0], at_rest[1] - modelled[1]};
            double there[2], more[2];
            transfer_load(c, elsewhere, a_x, there);
            transfer_load(c, at_rest, along_it, more);
            respond_to(s, n, held, e[LOAD_TRANSFER], 0.0, there[0] + more[0], there[1] + more[1]);
        }
    }

    double(*e)[3] = s->of_common;
    const double gust = gust_force(c, v_x), by_steering = 2.0 * c->c_f;
    if (s->common[BANK]) respond_to(s, n, held, e[BANK], 0.0, c->q.bank, 0.0);
    if (s->common[GUST])
        respond_to(s, n, held, e[GUST], 0.0, s->lighter * gust / c->mass, s->easier * c->q.gust_ahead * gust / c->yaw_inertia);
    if (s->common[RATIO]) respond_to_forces(s, n, held, e[RATIO], by_steering * (c->q.ratio * delta), 0.0);
    if (s->common[OFFSET]) respond_to_forces(s, n, held, e[OFFSET], by_steering * c->q.offset, 0.0);
    if (s->common[FRONT_SIDE_FORCE])
        respond_to_forces(s, n, held, e[FRONT_SIDE_FORCE], (c->q.front * loads[0] + fabs(loads[0] - 1.0)) * aside[0], 0.0);
    if (s->common[REAR_SIDE_FORCE])
        respond_to_forces(s, n, held, e[REAR_SIDE_FORCE], 0.0, (c->q.rear * loads[1] + fabs(loads[1] - 1.0)) * aside[1]);

    for (int k = 0; k < SENSED; k++) {
        if (!s->sensed[k]) continue;
        double error[2], premise[3], next[3];
        error_of(c, k, v_x, error);
        for (int i = 0; i < 3; i++) premise[i] = period * (jacobian[i][0] * error[0] + jacobian[i][2] * error[1]);
        const double *x = s->of_sensed[k];
        for (int i = 0; i < 3; i++)
            next[i] = (0.0 + n[i][0] * x[0] + n[i][1] * x[1] + n[i][2] * x[2])
                - ((0.0 + l[i][0] * error[0] + l[i][1] * error[1])
                   + (0.0 + c->m[i][0] * premise[0] + c->m[i][1] * premise[1] + c->m[i][2] * premise[2]));
        for (int i = 0; i < 3; i++) s->of_sensed[k][i] = next[i];
    }
}

/* Takes the reference motions on by the trapezoidal rule. */
static void advance_motions(Instance *s, double v_x, double r, double driven, double delta, const double aside[2]) {
    const Configuration *c = &s->c;
    const double half = 0.5 * c->period;
    if (s->transfers || c->q.friction > 0.0) {
        double factor[MOTIONS][2];
        for (int i = 0; i < MOTIONS; i++) {
            double loads[2], force[2];
            load_factors(c, (i == 0 ? 1.0 : 1.0 + c->q.load_transfer) * driven, loads);
            axle_forces(c, v_x, s->motion[i].x[0], s->motion[i].x[1], delta, force);
            const double holds[2] = {s->front_holds, s->rear_holds};
            for (int k = 0; k < 2; k++) {
                factor[i][k] = s->factor[i][k];
                if (i > 0 && c->q.friction > 0.0)
                    factor[i][k] *= 1.0 - deficit((fabs(factor[i][k] * force[k]) + aside[k]) / holds[k]);
                factor[i][k] *= loads[k];
            }
        }
        load_motions(s, factor);
    }
    const double share = (v_x / s->critical - DRAWN_FROM) / (1.0 - DRAWN_FROM);
    const double draw = DRAW * smaller(larger(share, 0.0), 1.0);
    for (size_t i = 0; i < s->motions; i++) {
        Motion *m = &s->motion[i];
        const double a_11 = half * m->lateral[0] / v_x, a_12 = half * (m->lateral[1] / v_x - v_x);
        const double a_21 = half * m->yaw[0] / v_x, a_22 = half * (m->yaw[1] / v_x - draw);
        const double b_1 = half * m->lateral[2] * delta, b_2 = half * (m->yaw[2] * delta + draw * r);
        const double right_1 = m->x[0] + a_11 * m->x[0] + a_12 * m->x[1] + 2.0 * b_1;
        const double right_2 = m->x[1] + a_21 * m->x[0] + a_22 * m->x[1] + 2.0 * b_2;
        const double determinant = (1.0 - a_11) * (1.0 - a_22) - a_12 * a_21;
        m->x[0] = ((1.0 - a_22) * right_1 + a_12 * right_2) / determinant;
        m->x[1] = (a_21 * right_1 + (1.0 - a_11) * right_2) / determinant;
    }
}

static void run_sample(Instance *s) {
    const Configuration *c = &s->c;
    const double v_x = s->y[0], r = s->y[1] - c->yaw_rate_bias, delta = s->u[1] - c->steering_offset;

    if (s->sample == 0) {
        s->filtered = v_x;
        for (int i = 0; i < MOTIONS; i++) s->motion[i].x[1] = r;
        for (int i = 0; i < 3; i++) s->z[i] = 0.0 + c->m[i][0] * v_x + c->m[i][1] * 0.0 + c->m[i][2] * r;
    }
    const double a_x = (v_x - s->filtered) / (ACCELERATION_FILTER + c->period);
    s->filtered += c->period * a_x;
    double x_hat[3];
    for (int i = 0; i < 3; i++) x_hat[i] = s->z[i] - (0.0 + c->e[i][0] * v_x + c->e[i][1] * r);

    /* Membership (8) and blend. */
    const double at_v_min = (1.0 / v_x - s->fast) / (s->slow - s->fast), at_v_max = 1.0 - at_v_min;
    const double at_r_max = (r - c->r_min) / (c->r_max - c->r_min), at_r_min = 1.0 - at_r_max;
    const double h[4] = {at_v_min * at_r_min, at_v_min * at_r_max, at_v_max * at_r_min, at_v_max * at_r_max};
    double n[3][3] = {{0}}, l[3][2] = {{0}};
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) n[i][j] += h[k] * c->n[k][i][j];
            for (int j = 0; j < 2; j++) l[i][j] += h[k] * c->l[k][i][j];
        }
    }

    /* g + B u + G phi, and the observer (10). */
    const double v_y = x_hat[1];
    const double g[3] = {
        s->drag * v_x * v_x / c->longitudinal_inertia,
        c->period * (s->cross * r / (c->mass * v_x) - v_x * r),
        s->damping * r / (c->yaw_inertia * v_x),
    };
    const double phi[3] = {0.0, s->g_phi * (v_y * v_y), 0.0};
    double w[3], z[3];
    for (int i = 0; i < 3; i++) w[i] = (g[i] + (0.0 + s->b[i][0] * s->u[0] + s->b[i][1] * delta)) + phi[i];
    for (int i = 0; i < 3; i++) {
        const double n_z = 0.0 + n[i][0] * s->z[0] + n[i][1] * s->z[1] + n[i][2] * s->z[2];
        const double l_y = 0.0 + l[i][0] * v_x + l[i][1] * r;
        const double m_w = 0.0 + c->m[i][0] * w[0] + c->m[i][1] * w[1] + c->m[i][2] * w[2];
        z[i] = (n_z + l_y) + m_w;
    }
    for (int i = 0; i < 3; i++) s->z[i] = z[i];

    /* Residual, less the response to what is known; levels of what is uncertain and of the fault. */
    s->residual[0] = v_x - x_hat[0] - s->known[0];
    s->residual[1] = r - x_hat[2] - s->known[2];
    const double fault = size(c, s->fault);
    const double seen = push(&s->seen, fault * fault, c->window);
    double uncertain = 0.0;
    if (s->any) {
        const double most = bound(s, v_x);
        uncertain = push(&s->uncertain, most * most, c->window);
    }
    const double asked = (s->u[0] - c->c_x * v_x * v_x) / c->longitudinal_inertia;
    double aside[2];
    hold_aside(s, v_x, aside);
    const double driven = asked > 0.0 ? larger(smaller(a_x, asked), 0.0) : smaller(larger(a_x, asked), 0.0);
    advance_responses(s, n, l, v_x, v_y, r, delta, a_x, asked, aside);
    advance_motions(s, v_x, r, driven, delta, aside);
    s->j_rms = push(&s->j, square(c, s->residual[0], s->residual[1]), c->window);

    /* Threshold with its start-up term. */
    const double decay_squared = c->start_up_decay * c->start_up_decay;
    if (s->started < c->window) {
        s->sum += s->power;
        s->power *= decay_squared;
        s->started++;
    } else {
        s->sum *= decay_squared;
    }
    s->j_th = c->threshold + c->start_up_amplitude * sqrt(s->sum / (double)c->window) + c->share * uncertain;
    s->detectability = seen / s->j_th;
    s->sample++;
}

Status fmi2SetReal(void *instance, const unsigned vr[], size_t nvr, const double value[]) {
    Instance *s = instance;
    for (size_t i = 0; i < nvr; i++) {
        switch (vr[i]) {
        case V_X: s->y[0] = value[i]; break;
        case R: s->y[1] = value[i]; break;
        case T_ENG: s->u[0] = value[i]; break;
        case DELTA: s->u[1] = value[i]; break;
        default: return ERROR;
        }
    }
    return OK;
}

Status fmi2GetReal(void *instance, const unsigned vr[], size_t nvr, double value[]) {
    const Instance *s = instance;
    for (size_t i = 0; i < nvr; i++) {
        switch (vr[i]) {
        case V_X: value[i] = s->y[0]; break;
        case R: value[i] = s->y[1]; break;
        case T_ENG: value[i] = s->u[0]; break;
        case DELTA: value[i] = s->u[1]; break;
        case RESIDUAL_V_X: value[i] = s->residual[0]; break;
        case RESIDUAL_R: value[i] = s->residual[1]; break;
        case J_RMS: value[i] = s->j_rms; break;
        case J_TH: value[i] = s->j_th; break;
        case DETECTABILITY: value[i] = s->detectability; break;
        default: return ERROR;
        }
    }
    return OK;
}

Status fmi2DoStep(void *instance, double time, double step, int no_set_state_prior) {
    Instance *s = instance;
    (void)no_set_state_prior;
    const double end = time + step - 1e-6 * s->c.period;
    while ((double)s->sample * s->c.period < end) run_sample(s);
    return OK;
}
