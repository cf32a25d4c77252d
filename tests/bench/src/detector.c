/* The detector in plain C, in the manner of the Reference FMUs: what a careful C programmer would
 * write from method 3 and 6 by hand, with the constants of the sample path computed once. The
 * operations on the data are in the same order as in the packaged library, so that the outputs are
 * equal bit for bit.
 *
 * Value references are those of SteeringFaultDetector.fmu. Range monitoring, state handling and the
 * other FMI functions are left out: they would only cost time here. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define MAX_WINDOW 256

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;
typedef enum { V_X, R, T_ENG, DELTA, RESIDUAL_V_X, RESIDUAL_R, J_RMS, J_TH } ValueReference;

/* Mirrored in benches/do_step.rs. */
typedef struct {
    double mass, yaw_inertia, longitudinal_inertia, l_f, l_r, c_f, c_r, c_x, c_y;
    double period;
    double v_x_min, v_x_max, r_min, r_max;
    double n[4][3][3], l[4][3][2], m[3][3], e[3][2];
    double weights[2], threshold, start_up_amplitude, start_up_decay;
    size_t window;
} Configuration;

typedef struct {
    Configuration c;
    /* Constants of the sample path. */
    double b[3][2], g_phi, drag, cross, damping, slow, fast;
    /* Inputs, states, outputs. */
    double y[2], u[2], z[3];
    double residual[2], j_rms, j_th;
    double squares[MAX_WINDOW];
    size_t oldest;
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
    return s;
}

void detector_free(Instance *s) { free(s); }

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

    /* Residual and its windowed RMS. */
    s->residual[0] = v_x - x_hat[0];
    s->residual[1] = r - x_hat[2];
    const double a = c->weights[0] * s->residual[0], b = c->weights[1] * s->residual[1];
    s->squares[s->oldest] = a * a + b * b;
    s->oldest = s->oldest + 1 < c->window ? s->oldest + 1 : 0;
    double sum = 0.0;
    for (size_t i = s->oldest; i < c->window; i++) sum += s->squares[i];
    for (size_t i = 0; i < s->oldest; i++) sum += s->squares[i];
    s->j_rms = sqrt(sum / (double)c->window);

    /* Threshold with its start-up term. */
    const double decay_squared = c->start_up_decay * c->start_up_decay;
    if (s->started < c->window) {
        s->sum += s->power;
        s->power *= decay_squared;
        s->started++;
    } else {
        s->sum *= decay_squared;
    }
    s->j_th = c->threshold + c->start_up_amplitude * sqrt(s->sum / (double)c->window);
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
