/* The vehicle's equations of motion in plain C: a yardstick for the compiled kernel's speed and a
 * second opinion on its results. Written from the equations, not from the kernel's source.
 *
 * Axes SNAME (x forward, y starboard, z down), earth NED, unit quaternion w x y z (body to NED).
 *   M nu_r' + C(nu_r) nu_r + D nu_r + d |nu_r| nu_r + g(eta) = tau        (Fossen 2021)
 * State: position (3), quaternion (4), nu over ground (6), one entry a thruster (lagged code, or
 * shaft speed in rev/s where the rotor inertia is not zero).
 *
 * Arithmetic only, no allocation, no libraries but libm.
 */
#include <math.h>
#include <string.h>

#define MOST_THRUSTERS 12
#define MOST_WALLS 5
#define BODY 13
#define STATE (BODY + MOST_THRUSTERS)
#define RK4 0

typedef struct {
    double mass, centre_of_mass[3], inertia[3][3], weight, buoyancy, centre_of_buoyancy[3];
    double added_mass[6][6], coriolis_fraction;
    double linear_damping[6][6], quadratic_damping[6], crossflow_fraction;
    double heave_lift_slope, sway_lift_slope, pitch_lift_slope, yaw_lift_slope, turnover_slope[2];
    double density, current[3];
    double wall_strength, wall_radius, wall_count;
    double wall_point[MOST_WALLS][3], wall_normal[MOST_WALLS][3];
    double tether_point[3], tether_drag_area, tether_pull, tether_anchor[3];
    double thruster_count;
    double thruster_position[MOST_THRUSTERS][3], thruster_direction[MOST_THRUSTERS][3];
    double thruster_type[MOST_THRUSTERS], thrust_gain[MOST_THRUSTERS];
    double reverse_gain[MOST_THRUSTERS], inflow_fraction[MOST_THRUSTERS];
    double dead_zone[MOST_THRUSTERS], code_max[MOST_THRUSTERS], code_min[MOST_THRUSTERS];
    double lag[MOST_THRUSTERS];
    double rotor_inertia[MOST_THRUSTERS], supply_drop, load_drop;
    double misalignment_azimuth[MOST_THRUSTERS], misalignment_elevation[MOST_THRUSTERS];
} Vehicle;

/* Regular grids: thrust [type][sign][speed][code] in N, torque [type][code][shaft speed] in N m,
 * screws [type] = D, K_T0..2, K_M0..2, shaft speed step and code step of the torque; steps [type] =
 * speed step, code step of the thrust. */
typedef struct {
    const double *thrust, *torque, *screws, *steps, *strips;
    long speeds, codes, torque_codes, torque_speeds, strip_count;
} Tables;

/* What does not change during a run. */
typedef struct {
    int thrusters;
    double mass[6][6], inverse[6][6];
    double axis[MOST_THRUSTERS][3];
} Constant;

unsigned long vehicle_size(void) { return sizeof(Vehicle); }

static inline double square(double a) { return a * a; }

static inline double clamp(double a, double low, double high)
{
    return a < low ? low : (a > high ? high : a);
}

static inline void add_cross(const double a[3], const double b[3], double out[3])
{
    out[0] += a[1] * b[2] - a[2] * b[1];
    out[1] += a[2] * b[0] - a[0] * b[2];
    out[2] += a[0] * b[1] - a[1] * b[0];
}

static inline void add_force_at(const double place[3], const double f[3], double force[6])
{
    for (int k = 0; k < 3; k++)
        force[k] += f[k];
    add_cross(place, f, force + 3);
}

static inline void rotation_of(const double q[4], double r[3][3])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    r[0][0] = 1.0 - 2.0 * (y * y + z * z);
    r[0][1] = 2.0 * (x * y - w * z);
    r[0][2] = 2.0 * (x * z + w * y);
    r[1][0] = 2.0 * (x * y + w * z);
    r[1][1] = 1.0 - 2.0 * (x * x + z * z);
    r[1][2] = 2.0 * (y * z - w * x);
    r[2][0] = 2.0 * (x * z - w * y);
    r[2][1] = 2.0 * (y * z + w * x);
    r[2][2] = 1.0 - 2.0 * (x * x + y * y);
}

/* Rates of position and quaternion. */
static inline void kinematics(const double q[4], double r[3][3], const double nu[6], double rate[7])
{
    for (int i = 0; i < 3; i++)
        rate[i] = r[i][0] * nu[0] + r[i][1] * nu[1] + r[i][2] * nu[2];
    rate[3] = -0.5 * (q[1] * nu[3] + q[2] * nu[4] + q[3] * nu[5]);
    rate[4] = 0.5 * (q[0] * nu[3] - q[3] * nu[4] + q[2] * nu[5]);
    rate[5] = 0.5 * (q[3] * nu[3] + q[0] * nu[4] - q[1] * nu[5]);
    rate[6] = 0.5 * (-q[2] * nu[3] + q[1] * nu[4] + q[0] * nu[5]);
}

/* M = [m I, -m S(r); m S(r), I_o] + share M_A. */
static void total_mass(const Vehicle *v, double share, double m[6][6])
{
    const double *r = v->centre_of_mass;
    const double s[3][3] = {{0, -r[2], r[1]}, {r[2], 0, -r[0]}, {-r[1], r[0], 0}};
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            m[i][j] = share * v->added_mass[i][j];
    for (int i = 0; i < 3; i++) {
        m[i][i] += v->mass;
        for (int j = 0; j < 3; j++) {
            m[i][3 + j] -= v->mass * s[i][j];
            m[3 + i][j] += v->mass * s[i][j];
            m[3 + i][3 + j] += v->inertia[i][j];
        }
    }
}

/* Solve a positive definite system in place by elimination without pivoting. */
static void solve(double m[6][6], double x[6])
{
    for (int k = 0; k < 6; k++)
        for (int i = k + 1; i < 6; i++) {
            const double share = m[i][k] / m[k][k];
            for (int j = k + 1; j < 6; j++)
                m[i][j] -= share * m[k][j];
            x[i] -= share * x[k];
        }
    for (int i = 5; i >= 0; i--) {
        for (int j = i + 1; j < 6; j++)
            x[i] -= m[i][j] * x[j];
        x[i] /= m[i][i];
    }
}

static void invert(double m[6][6], double inverse[6][6])
{
    for (int column = 0; column < 6; column++) {
        double copy[6][6], x[6] = {0};
        memcpy(copy, m, sizeof copy);
        x[column] = 1.0;
        solve(copy, x);
        for (int i = 0; i < 6; i++)
            inverse[i][column] = x[i];
    }
}

/* Stated direction d, tilted by azimuth towards s = z x d and by elevation away from n = d x s. */
static void thrust_axis(const double stated[3], double azimuth, double elevation, double axis[3])
{
    const double x = stated[0], y = stated[1], z = stated[2], flat = hypot(x, y);
    const double s[3] = {flat > 1e-6 ? -y / flat : 0.0, flat > 1e-6 ? x / flat : 1.0, 0.0};
    const double n[3] = {-z * s[1], z * s[0], x * s[1] - y * s[0]};
    for (int k = 0; k < 3; k++)
        axis[k] = cos(elevation) * (cos(azimuth) * stated[k] + sin(azimuth) * s[k])
                - sin(elevation) * n[k];
}

/* Bilinear value; beyond the last row along its slope, beyond the last column held. */
static double look_up(const double *table, long rows, long columns, double row, double column)
{
    const double c = clamp(column, 0.0, (double)(columns - 1));
    const long j = (long)c < columns - 2 ? (long)c : columns - 2;
    const double share = c - (double)j;
    if (rows == 1)
        return table[j] * (1.0 - share) + table[j + 1] * share;
    const double r = row > 0.0 ? row : 0.0;
    const long i = (long)r < rows - 2 ? (long)r : rows - 2;
    const double *low = table + i * columns + j, *high = low + columns;
    const double below = low[0] * (1.0 - share) + low[1] * share;
    const double above = high[0] * (1.0 - share) + high[1] * share;
    return below + (r - (double)i) * (above - below);
}

static void effective_codes(const Vehicle *v, int count, const double *command, double *codes)
{
    double load = 0.0;
    for (int i = 0; i < count; i++) {
        const double most = v->code_max[i];
        codes[i] = clamp(command[i], fmax(v->code_min[i], -most), most);
        load += square(codes[i] / most);
    }
    const double supply = 1.0 - v->supply_drop - (count ? v->load_drop * load / count : 0.0);
    for (int i = 0; i < count; i++) {
        const double most = v->code_max[i], lost = v->dead_zone[i];
        const double code = codes[i];
        const double left = fabs(code) - lost;
        const double size = left > 0.0 ? left * most / (most - lost) : 0.0;
        codes[i] = supply * (lost != 0.0 ? copysign(size, code) : code);
    }
}

/* Static thrust T(|N|, V) or rho D^4 (K_T0 n^2 + K_T1 n V/D + K_T2 V^2/D^2), along the axis. */
static double thrust_of(const Vehicle *v, const Tables *t, int i, double actuator, double speed)
{
    const long kind = (long)v->thruster_type[i];
    const double size = fabs(actuator), sign = actuator < 0.0 ? -1.0 : 1.0;
    const double along = sign * speed > 0.0 ? sign * speed : 0.0;
    double value;
    if (v->rotor_inertia[i] > 0.0) {
        const double *screw = t->screws + 10 * kind, advance = along / screw[0];
        value = screw[1] * size * size + screw[2] * size * advance + screw[3] * advance * advance;
        value *= v->density * square(square(screw[0]));
    } else {
        const double *table = t->thrust + (2 * kind + (actuator < 0.0)) * t->speeds * t->codes;
        const double *step = t->steps + 2 * kind;
        value = look_up(table, t->speeds, t->codes, along / step[0], size / step[1]);
    }
    if (value <= 0.0)
        return 0.0;
    value *= v->thrust_gain[i];
    return actuator < 0.0 ? -value * v->reverse_gain[i] : value;
}

/* 2 pi J n' = M_drive(n, N) - rho D^5 (K_M0 n |n| + K_M1 n V/D + K_M2 V^2/D^2). */
static double shaft_rate(const Vehicle *v, const Tables *t, int i, double shaft, double code,
                         double speed)
{
    const long kind = (long)v->thruster_type[i];
    const double *screw = t->screws + 10 * kind;
    const double sign = code > 0.0 || (code == 0.0 && speed >= 0.0) ? 1.0 : -1.0, n = sign * shaft;
    const double advance = (sign * speed > 0.0 ? sign * speed : 0.0) / screw[0];
    double drive = 0.0, load = screw[4] * n * fabs(n);
    if (code != 0.0)
        drive = look_up(t->torque + kind * t->torque_codes * t->torque_speeds, t->torque_codes,
                        t->torque_speeds, fabs(code) / screw[8], n / screw[7]);
    if (n >= 0.0)
        load += screw[5] * n * advance + screw[6] * advance * advance;
    load *= v->density * square(square(screw[0])) * screw[0];
    return sign * (drive - load) / (2.0 * 3.14159265358979323846 * v->rotor_inertia[i]);
}

static double wall_factor(const Vehicle *v, const double place[3])
{
    double factor = 1.0;
    const int count = (int)v->wall_count < MOST_WALLS ? (int)v->wall_count : MOST_WALLS;
    if (v->wall_strength == 0.0)
        return factor;
    for (int k = 0; k < count; k++) {
        double distance = 0.0;
        for (int i = 0; i < 3; i++)
            distance += (place[i] - v->wall_point[k][i]) * v->wall_normal[k][i];
        const double near = distance > v->wall_radius ? v->wall_radius / distance : 1.0;
        factor += v->wall_strength * near * near * near;
    }
    return factor;
}

static void subtract_damping(const Vehicle *v, const Tables *t, const double u[6], double near_wall,
                             double force[6])
{
    for (int i = 0; i < 6; i++) {
        double total = v->quadratic_damping[i] * fabs(u[i]) * u[i];
        for (int j = 0; j < 6; j++)
            total += v->linear_damping[i][j] * u[j];
        force[i] -= near_wall * total;
    }
    if (v->crossflow_fraction != 0.0) {
        const double half = 0.5 * v->density * v->crossflow_fraction;
        for (long k = 0; k < t->strip_count; k++) {
            const double *strip = t->strips + 3 * k, x = strip[0];
            double turn = x * u[5], both = u[1] + turn;
            const double side = half * strip[1] *
                (fabs(both) * both - fabs(u[1]) * u[1] - fabs(turn) * turn);
            turn = -x * u[4], both = u[2] + turn;
            const double down = half * strip[2] *
                (fabs(both) * both - fabs(u[2]) * u[2] - fabs(turn) * turn);
            force[1] -= side;
            force[5] -= x * side;
            force[2] -= down;
            force[4] += x * down;
        }
    }
    force[1] -= v->sway_lift_slope * fabs(u[0]) * u[1];
    force[2] -= v->heave_lift_slope * fabs(u[0]) * u[2];
    const double back = u[0] - fabs(u[0]);
    force[4] += (v->pitch_lift_slope * fabs(u[0]) + v->turnover_slope[0] * back) * u[2];
    force[5] += (v->yaw_lift_slope * fabs(u[0]) + v->turnover_slope[1] * back) * u[1];
}

static void add_tether(const Vehicle *v, const double place[3], double r[3][3], const double u[6],
                       double force[6])
{
    if (v->tether_drag_area == 0.0 && v->tether_pull == 0.0)
        return;
    double flow[3] = {u[0], u[1], u[2]}, f[3], away[3], pull[3];
    add_cross(u + 3, v->tether_point, flow);
    const double speed = sqrt(square(flow[0]) + square(flow[1]) + square(flow[2]));
    for (int k = 0; k < 3; k++) {
        f[k] = -0.5 * v->density * v->tether_drag_area * speed * flow[k];
        away[k] = v->tether_anchor[k] - place[k];
    }
    for (int k = 0; k < 3; k++)
        pull[k] = r[0][k] * away[0] + r[1][k] * away[1] + r[2][k] * away[2] - v->tether_point[k];
    const double length = sqrt(square(pull[0]) + square(pull[1]) + square(pull[2]));
    for (int k = 0; k < 3; k++)
        f[k] += v->tether_pull * pull[k] / (length > 1.0 ? length : 1.0);
    add_force_at(v->tether_point, f, force);
}

static void rates(const Vehicle *v, const Tables *t, const Constant *c, const double *x,
                  const double *codes, const double external[6], double *rate, double *thrust)
{
    double r[3][3], water[3], u[6], force[6], inflow[MOST_THRUSTERS], near[6][6];
    const double *omega = x + 10;
    rotation_of(x + 3, r);
    for (int k = 0; k < 3; k++) {
        water[k] = r[0][k] * v->current[0] + r[1][k] * v->current[1] + r[2][k] * v->current[2];
        u[k] = x[7 + k] - water[k];
        u[3 + k] = omega[k];
    }
    memcpy(force, external, sizeof force);

    for (int i = 0; i < c->thrusters; i++) {
        const double *axis = c->axis[i], *place = v->thruster_position[i];
        double flow[3] = {u[0], u[1], u[2]}, f[3];
        add_cross(omega, place, flow);
        inflow[i] = v->inflow_fraction[i] *
            (axis[0] * flow[0] + axis[1] * flow[1] + axis[2] * flow[2]);
        thrust[i] = thrust_of(v, t, i, x[BODY + i], inflow[i]);
        for (int k = 0; k < 3; k++)
            f[k] = thrust[i] * axis[k];
        add_force_at(place, f, force);
    }

    double weight[3], lift[3];
    for (int k = 0; k < 3; k++) {
        weight[k] = v->weight * r[2][k];
        lift[k] = -v->buoyancy * r[2][k];
    }
    add_force_at(v->centre_of_mass, weight, force);
    add_force_at(v->centre_of_buoyancy, lift, force);
    add_tether(v, x, r, u, force);
    const double near_wall = wall_factor(v, x);
    subtract_damping(v, t, u, near_wall, force);

    const double(*m)[6] = c->mass;
    if (near_wall != 1.0) {
        total_mass(v, near_wall, near);
        m = (const double(*)[6])near;
    }
    double momentum[6], lost[6] = {0};
    for (int i = 0; i < 6; i++) {
        momentum[i] = 0.0;
        for (int j = 0; j < 6; j++)
            momentum[i] += m[i][j] * u[j];
    }
    add_cross(omega, momentum, lost);
    add_cross(omega, momentum + 3, lost + 3);
    add_cross(u, momentum, lost + 3);
    for (int k = 0; k < 6; k++)
        force[k] -= v->coriolis_fraction * lost[k];

    if (near_wall != 1.0) {
        solve(near, force);
        memcpy(rate + 7, force, sizeof force);
    } else {
        for (int i = 0; i < 6; i++) {
            double total = 0.0;
            for (int j = 0; j < 6; j++)
                total += c->inverse[i][j] * force[j];
            rate[7 + i] = total;
        }
    }
    /* nu = nu_r + R' current, and the second term turns against the body */
    add_cross(water, omega, rate + 7);
    kinematics(x + 3, r, x + 7, rate);
    for (int i = 0; i < MOST_THRUSTERS; i++)
        rate[BODY + i] = 0.0;
    for (int i = 0; i < c->thrusters; i++)
        if (v->rotor_inertia[i] > 0.0)
            rate[BODY + i] = shaft_rate(v, t, i, x[BODY + i], codes[i], inflow[i]);
}

/* First-order lag with a constant command, in closed form; `left` is what it leaves of the
 * distance after the time in question, computed once a run. */
static void lagged(const Vehicle *v, int count, const double *start, const double *codes,
                   const double *left, double *x)
{
    for (int i = 0; i < count; i++) {
        if (v->rotor_inertia[i] > 0.0)
            continue;
        const double away = start[BODY + i] - codes[i];
        x[BODY + i] = codes[i] + away * left[i];
    }
}

/* Integrate `count` commands (count, 12), each held for dt. Fills states (count + 1, STATE),
 * accelerations (count + 1, 6) and thrusts (count + 1, 12). */
void simulate_c(const Vehicle *v, const Tables *t, const double *initial, const double *commands,
                long count, const double *external, double dt, int method, double *states,
                double *accelerations, double *thrusts)
{
    Constant c;
    double x[STATE], y[STATE], k1[STATE], k2[STATE], k3[STATE], k4[STATE];
    double codes[MOST_THRUSTERS] = {0}, thrust[MOST_THRUSTERS] = {0}, spare[MOST_THRUSTERS];
    double left[3][MOST_THRUSTERS] = {{0}}; /* at the start, the middle, the end of a step */
    c.thrusters = (int)v->thruster_count;
    total_mass(v, 1.0, c.mass);
    invert(c.mass, c.inverse);
    for (int i = 0; i < c.thrusters; i++)
        thrust_axis(v->thruster_direction[i], v->misalignment_azimuth[i],
                    v->misalignment_elevation[i], c.axis[i]);
    for (int i = 0; i < c.thrusters; i++)
        for (int half = 0; half < 3 && v->lag[i] > 0.0; half++)
            left[half][i] = exp(-0.5 * half * dt / v->lag[i]);
    memcpy(x, initial, sizeof x);
    for (long k = 0; k <= count; k++) {
        const long now = k < count ? k : count - 1;
        effective_codes(v, c.thrusters, commands + MOST_THRUSTERS * now, codes);
        lagged(v, c.thrusters, x, codes, left[0], x);
        rates(v, t, &c, x, codes, external, k1, thrust);
        memcpy(states + STATE * k, x, sizeof x);
        memcpy(accelerations + 6 * k, k1 + 7, 6 * sizeof(double));
        memcpy(thrusts + MOST_THRUSTERS * k, thrust, sizeof thrust);
        if (k == count)
            break;
        if (method == RK4) {
            for (int i = 0; i < STATE; i++)
                y[i] = x[i] + 0.5 * dt * k1[i];
            lagged(v, c.thrusters, x, codes, left[1], y);
            rates(v, t, &c, y, codes, external, k2, spare);
            for (int i = 0; i < STATE; i++)
                y[i] = x[i] + 0.5 * dt * k2[i];
            lagged(v, c.thrusters, x, codes, left[1], y);
            rates(v, t, &c, y, codes, external, k3, spare);
            for (int i = 0; i < STATE; i++)
                y[i] = x[i] + dt * k3[i];
            lagged(v, c.thrusters, x, codes, left[2], y);
            rates(v, t, &c, y, codes, external, k4, spare);
            for (int i = 0; i < STATE; i++)
                y[i] = x[i] + dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        } else {
            /* velocities first; the pose moves with the new velocity */
            double r[3][3];
            for (int i = 7; i < STATE; i++)
                y[i] = x[i] + dt * k1[i];
            rotation_of(x + 3, r);
            kinematics(x + 3, r, y + 7, k1);
            for (int i = 0; i < 7; i++)
                y[i] = x[i] + dt * k1[i];
        }
        lagged(v, c.thrusters, x, codes, left[2], y);
        const double norm = sqrt(square(y[3]) + square(y[4]) + square(y[5]) + square(y[6]));
        for (int i = 3; i < 7; i++)
            y[i] /= norm;
        memcpy(x, y, sizeof x);
    }
}
