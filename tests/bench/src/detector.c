/* The detector in plain C, in the manner of the Reference FMUs: what a careful C programmer would
 * write from method 3 and 6 by hand, with the constants of the sample path computed once. The
 * operations on the data are in the same order as in the packaged library, so that the outputs are
 * equal bit for bit.
 *
 * Value references are those of SteeringFaultDetector.fmu. Range monitoring, state handling, a modelled
 * or uncertain actuator, which the designs compared do not have, and the other FMI functions are left
 * out: they would only cost time here. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define MAX_WINDOW 256

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef enum { V_X, R, T_ENG, DELTA, RESIDUAL_V_X, RESIDUAL_R, J_RMS, J_TH, DETECTABILITY = 12 } ValueReference;
/* Uncertainties, in the order of the detector's. */
enum { MASS, YAW_INERTIA, FRONT_STIFFNESS, REAR_STIFFNESS, BANK, GUST, UNCERTAINTIES };

/* Mirrored in lib.rs. */
typedef struct {
    double mass, yaw_inertia, longitudinal_inertia, l_f, l_r, c_f, c_r, c_x, c_y;
    double period;
    double v_x_min, v_x_max, r_min, r_max;
    double n[4][3][3], l[4][3][2], m[3][3], e[3][2];
    double weights[2], threshold, start_up_amplitude, start_up_decay;
    double share, uncertainty[5], gust_speed, gust_coefficient, gust_ahead, smallest_fault[3];
    size_t euler_correction, window;
} Configuration;

/* Window of squares, as in the detector: the sum of this round through the ring and that of what is left
 * of the round before. */
typedef struct {
    double ring[MAX_WINDOW], newer;
    size_t next;
} Window;

typedef struct {
    Configuration c;
    /* Constants of the sample path. */
    double b[3][2], g_phi, drag, cross, damping, slow, fast, m_fault[3], half_square;
    int acts[UNCERTAINTIES], any;
    /* Inputs, states, outputs. */
    double y[2], u[2], z[3];
    double residual[2], j_rms, j_th, detectability;
    double remainder[3], responses[UNCERTAINTIES][3], fault[3];
    Window j, uncertain, seen;
    double power, sum;
    size_t started;
    unsigned long long sample;
} Instance;

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
    for (int i = 0; i < 3; i++)
        s->m_fault[i] = 0.0 + c->m[i][0] * c->smallest_fault[0] + c->m[i][1] * c->smallest_fault[1] + c->m[i][2] * c->smallest_fault[2];
    for (int k = 0; k < UNCERTAINTIES; k++) {
        const int is = k == GUST ? c->gust_speed > 0.0 && c->gust_coefficient > 0.0 : c->uncertainty[k] > 0.0;
        s->acts[k] = c->share > 0.0 && is;
        s->any |= s->acts[k];
    }
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

/* e+ = N e + M w. */
static void respond(double n[3][3], const Configuration *c, double e[3], const double w[3]) {
    double next[3];
    for (int i = 0; i < 3; i++)
        next[i] = (0.0 + n[i][0] * e[0] + n[i][1] * e[1] + n[i][2] * e[2])
            + (0.0 + c->m[i][0] * w[0] + c->m[i][1] * w[1] + c->m[i][2] * w[2]);
    for (int i = 0; i < 3; i++) e[i] = next[i];
}

/* Responses to Euler's remainder, to what is uncertain and to the smallest fault: method 6. */
static void advance_responses(Instance *s, double n[3][3], double v_x, double v_y, double r) {
    const Configuration *c = &s->c;
    double fault[3];
    for (int i = 0; i < 3; i++)
        fault[i] = (0.0 + n[i][0] * s->fault[0] + n[i][1] * s->fault[1] + n[i][2] * s->fault[2]) + s->m_fault[i];
    for (int i = 0; i < 3; i++) s->fault[i] = fault[i];
    if (!c->euler_correction && !s->any) return;

    const double t_eng = s->u[0], delta = s->u[1];
    const double front = 2.0 * c->c_f * (delta - (v_y + c->l_f * r) / v_x);
    const double rear = 2.0 * c->c_r * ((c->l_r * r - v_y) / v_x);
    if (c->euler_correction) {
        const double v_x_dot = (t_eng - c->c_x * v_x * v_x) / c->longitudinal_inertia + v_y * r;
        const double v_y_dot = (front + rear - c->c_y * v_y * v_y) / c->mass - v_x * r;
        const double r_dot = (c->l_f * front - c->l_r * rear) / c->yaw_inertia;
        const double lateral_f = v_y + c->l_f * r, lateral_r = v_y - c->l_r * r;
        const double front_dot = -2.0 * c->c_f * (((v_y_dot + c->l_f * r_dot) - lateral_f / v_x * v_x_dot) / v_x);
        const double rear_dot = -2.0 * c->c_r * (((v_y_dot - c->l_r * r_dot) - lateral_r / v_x * v_x_dot) / v_x);
        const double w[3] = {
            s->half_square * (-2.0 * c->c_x * v_x * v_x_dot / c->longitudinal_inertia + v_y_dot * r + v_y * r_dot),
            s->half_square * ((front_dot + rear_dot - 2.0 * c->c_y * v_y * v_y_dot) / c->mass - v_x_dot * r - v_x * r_dot),
            s->half_square * ((c->l_f * front_dot - c->l_r * rear_dot) / c->yaw_inertia),
        };
        respond(n, c, s->remainder, w);
    }
    for (int k = 0; k < UNCERTAINTIES; k++) {
        if (!s->acts[k]) continue;
        double x = 0.0, y = 0.0, z = 0.0;
        const double by = k == GUST ? 0.0 : c->uncertainty[k];
        switch (k) {
        case MASS:
            x = by * ((t_eng - c->c_x * v_x * v_x) / c->longitudinal_inertia);
            y = by * (front + rear - c->c_y * v_y * v_y) / c->mass;
            break;
        case YAW_INERTIA: z = by * (c->l_f * front - c->l_r * rear) / c->yaw_inertia; break;
        case FRONT_STIFFNESS:
            y = by * front / c->mass;
            z = by * c->l_f * front / c->yaw_inertia;
            break;
        case REAR_STIFFNESS:
            y = by * rear / c->mass;
            z = -by * c->l_r * rear / c->yaw_inertia;
            break;
        case BANK: y = by; break;
        case GUST: {
            const double speed = c->gust_speed;
            const double force = c->gust_coefficient * speed * sqrt(v_x * v_x + speed * speed);
            y = force / c->mass;
            z = c->gust_ahead * force / c->yaw_inertia;
        }
        }
        const double w[3] = {c->period * x, c->period * y, c->period * z};
        respond(n, c, s->responses[k], w);
    }
}

static void run_sample(Instance *s) {
    const Configuration *c = &s->c;
    const double v_x = s->y[0], r = s->y[1];

    if (s->sample == 0) {
        for (int i = 0; i < 3; i++) s->z[i] = 0.0 + c->m[i][0] * v_x + c->m[i][1] * 0.0 + c->m[i][2] * r;
    }
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
    for (int i = 0; i < 3; i++) w[i] = (g[i] + (0.0 + s->b[i][0] * s->u[0] + s->b[i][1] * s->u[1])) + phi[i];
    for (int i = 0; i < 3; i++) {
        const double n_z = 0.0 + n[i][0] * s->z[0] + n[i][1] * s->z[1] + n[i][2] * s->z[2];
        const double l_y = 0.0 + l[i][0] * v_x + l[i][1] * r;
        const double m_w = 0.0 + c->m[i][0] * w[0] + c->m[i][1] * w[1] + c->m[i][2] * w[2];
        z[i] = (n_z + l_y) + m_w;
    }
    for (int i = 0; i < 3; i++) s->z[i] = z[i];

    /* Residual, less the response to Euler's remainder; levels of what is uncertain and of the fault. */
    s->residual[0] = v_x - x_hat[0] - s->remainder[0];
    s->residual[1] = r - x_hat[2] - s->remainder[2];
    const double seen = push(&s->seen, square(c, s->fault[0], s->fault[2]), c->window);
    double uncertain = 0.0;
    if (s->any) {
        double bound = 0.0;
        for (int k = 0; k < UNCERTAINTIES; k++)
            if (s->acts[k]) bound += sqrt(square(c, s->responses[k][0], s->responses[k][2]));
        uncertain = push(&s->uncertain, bound * bound, c->window);
    }
    advance_responses(s, n, v_x, v_y, r);
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
