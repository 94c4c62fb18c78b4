/*
 * lostmotion for C and C++: how far a real machine leaves the programmed contour, and what each way of
 * compensating backlash does about it.
 *
 * Every function answers a status; lm_error() tells what went wrong in the calling thread. What the
 * functions give are handles: they are looked up, never followed, so that a null, a freed one or one of
 * another kind is an error. Pointers that are handed in have to point to what the function says.
 * "Threads: any" says that all threads may call at the same time, with the same handles, too; "one at a
 * time" that each handle is for one thread at a time (another one is told LM_STATUS_BUSY). "Real time:
 * yes" says that the call allocates and frees nothing, waits for no lock and enters no system call, with every
 * method of the library and for as long as the axis moves: it takes all its memory when it is made.
 *
 * Made from crates/c/src by cbindgen: do not edit.
 */

#ifndef LOSTMOTION_H
#define LOSTMOTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * Version of the interface; it rises where a program that was compiled with an older header would
 * break.
 */
#define LM_ABI 1

/**
 * `LmSetpoint.velocity` is given.
 */
#define LM_SETPOINT_VELOCITY 1

/**
 * `LmSetpoint.acceleration` is given.
 */
#define LM_SETPOINT_ACCELERATION 2

/**
 * `LmSetpoint.load_force` is given.
 */
#define LM_SETPOINT_LOAD_FORCE 4

/**
 * How a call went.
 */
typedef enum LmStatus {
  /**
   * It did what it says.
   */
  LM_STATUS_OK = 0,
  /**
   * A pointer or handle that has to be given is null.
   */
  LM_STATUS_NULL = 1,
  /**
   * No handle of this kind, or one that was freed.
   */
  LM_STATUS_HANDLE = 2,
  /**
   * Another thread, or a callback that is running, uses the object.
   */
  LM_STATUS_BUSY = 3,
  /**
   * A size or an index that does not fit, a pointer that is not aligned.
   */
  LM_STATUS_SIZE = 4,
  /**
   * A value that means nothing.
   */
  LM_STATUS_OPTION = 5,
  /**
   * The part program.
   */
  LM_STATUS_PROGRAM = 6,
  /**
   * The description of the machine.
   */
  LM_STATUS_MACHINE = 7,
  /**
   * The compensator, or its axis.
   */
  LM_STATUS_METHOD = 8,
  /**
   * Columns of a log, setpoints.
   */
  LM_STATUS_DATA = 9,
  /**
   * A callback has ended the run.
   */
  LM_STATUS_CANCELLED = 10,
  /**
   * Something else; the message says what.
   */
  LM_STATUS_OTHER = 11,
  /**
   * A fault of the library's own. The object that was being changed can only be freed.
   */
  LM_STATUS_INTERNAL = 12,
} LmStatus;

/**
 * An axis with a compensator: drive, motor, shaft with a gap, load.
 */
typedef struct LmAxis LmAxis;

/**
 * A list of findings.
 */
typedef struct LmFindings LmFindings;

/**
 * A machine: checked, and never changed.
 */
typedef struct LmMachine LmMachine;

/**
 * The canonical operations of a program, made as they are asked for.
 */
typedef struct LmOperations LmOperations;

/**
 * A part program: a text, or a file that is read where it stands.
 */
typedef struct LmProgram LmProgram;

/**
 * What came of a run. It does not change.
 */
typedef struct LmRun LmRun;

/**
 * A program on a machine, and how the one is to run on the other.
 */
typedef struct LmSimulation LmSimulation;

/**
 * A text: UTF-8 with a zero at its end.
 */
typedef struct LmText LmText;

/**
 * What a compensator may know of its axis; all angles are rad at the motor's shaft.
 */
typedef struct LmAxisFacts {
  /**
   * Unit of positions: "mm", "deg" or "rad".
   */
  const char *unit;
  /**
   * Angle of the motor for a unit of the axis, rad.
   */
  double motor_rad_per_unit;
  /**
   * Time between two calls of `step`, s.
   */
  double servo_period_s;
  /**
   * Total gap, rad.
   */
  double gap_rad;
  /**
   * Inertia at the motor, its own and what turns with it, kg m2.
   */
  double motor_inertia_kgm2;
  /**
   * Coulomb friction of the motor, N m.
   */
  double motor_coulomb_nm;
  /**
   * Inertia of the load, kg m2.
   */
  double load_inertia_kgm2;
  /**
   * Coulomb friction of the load, N m.
   */
  double load_coulomb_nm;
  /**
   * Viscous friction of the load, N m s/rad.
   */
  double load_viscous_nm_s_per_rad;
  /**
   * Constant torque on the load, N m.
   */
  double load_constant_nm;
  /**
   * Stiffness of the shaft, N m/rad.
   */
  double stiffness_nm_per_rad;
  /**
   * Damping of the shaft, N m s/rad.
   */
  double damping_nm_s_per_rad;
} LmAxisFacts;

/**
 * What a compensator sees at a servo tick: rad, rad/s, rad/s2 at the motor, A.
 */
typedef struct LmTick {
  /**
   * Reference.
   */
  double position;
  /**
   * Its velocity.
   */
  double velocity;
  /**
   * Its acceleration.
   */
  double acceleration;
  /**
   * Reference one servo tick ahead.
   */
  double next_position;
  /**
   * Its velocity.
   */
  double next_velocity;
  /**
   * Its acceleration.
   */
  double next_acceleration;
  /**
   * Motor from its encoder.
   */
  double motor_position;
  /**
   * Motor's velocity as the drive computes it.
   */
  double motor_velocity;
  /**
   * Torque-forming current at the tick.
   */
  double current;
  /**
   * Its mean over the last servo period.
   */
  double mean_current;
  /**
   * Load from its scale; NaN unless the compensator has `load_scale`.
   */
  double load_position;
  /**
   * Whether the drive was at a limit in the last period.
   */
  bool saturated;
} LmTick;

/**
 * What a compensator answers; zeros where it has nothing to say.
 */
typedef struct LmCorrection {
  /**
   * Added to the position reference, rad.
   */
  double position;
  /**
   * Added to the velocity feed-forward, rad/s.
   */
  double velocity;
  /**
   * Added to the torque feed-forward, N m.
   */
  double torque;
  /**
   * Subtracted from the measured motor position, rad.
   */
  double feedback;
} LmCorrection;

/**
 * A compensator: four functions that work on a state of the caller's.
 *
 * One state is made for each axis and method, and copied where the library tries a motion ahead.
 * Different states may be stepped on different threads at the same time; one state is used by one
 * thread at a time. The functions must return: no `longjmp`, no C++ exception.
 */
typedef struct LmCompensator {
  /**
   * `sizeof(LmCompensator)`.
   */
  size_t size;
  /**
   * Name in the results.
   */
  const char *name;
  /**
   * Handed to `create`; it has to outlive the simulation or axis.
   */
  void *user;
  /**
   * Makes the state of an axis that stands at `motor_position` rad; null where it cannot.
   */
  void *(*create)(void *user,
                  const struct LmAxisFacts *facts,
                  double motor_position);
  /**
   * Copies a state; null where it cannot.
   */
  void *(*copy)(const void *state);
  /**
   * Frees a state.
   */
  void (*destroy)(void *state);
  /**
   * A servo tick: sets the parts of the correction that are not zero.
   */
  void (*step)(void *state,
               const struct LmTick *tick,
               struct LmCorrection *correction);
  /**
   * Whether it is shown the load's scale.
   */
  bool load_scale;
} LmCompensator;

/**
 * What is fixed of an axis.
 */
typedef struct LmAxisInfo {
  /**
   * Unit of positions: "mm", "deg" or "rad".
   */
  const char *unit;
  /**
   * Servo ticks in a command cycle: samples that each setpoint makes.
   */
  size_t servo_ticks;
  /**
   * Command cycles by which the reference lags behind the setpoints.
   */
  uint32_t delay_ticks;
  /**
   * Time between two servo ticks, s.
   */
  double servo_period_s;
  /**
   * Time between two setpoints, s.
   */
  double command_period_s;
  /**
   * Total gap, in the unit of the axis.
   */
  double gap;
} LmAxisInfo;

/**
 * A command of the control, one each command cycle, in the unit of the axis (mm, deg or rad).
 */
typedef struct LmSetpoint {
  /**
   * Position.
   */
  double position;
  /**
   * Velocity per s, where `given` has `LM_SETPOINT_VELOCITY`.
   */
  double velocity;
  /**
   * Acceleration per s2, where `given` has `LM_SETPOINT_ACCELERATION`.
   */
  double acceleration;
  /**
   * Force on the load against the positive direction, N, or N m at a load that turns, where
   * `given` has `LM_SETPOINT_LOAD_FORCE`.
   */
  double load_force;
  /**
   * Which of these are given: a sum of `LM_SETPOINT_...`.
   */
  uint32_t given;
} LmSetpoint;

/**
 * An axis at a servo tick: positions in its unit at the load, current, torque and estimates at the
 * motor. The columns of the command's axis traces.
 */
typedef struct LmAxisSample {
  /**
   * Time since the start, s.
   */
  double time_s;
  /**
   * Reference of the servo.
   */
  double reference;
  /**
   * Its velocity per s.
   */
  double reference_velocity;
  /**
   * Its acceleration per s2.
   */
  double reference_acceleration;
  /**
   * Motor, at the load's side of the transmission.
   */
  double motor;
  /**
   * Its velocity per s.
   */
  double motor_velocity;
  /**
   * Load.
   */
  double load;
  /**
   * Its velocity per s.
   */
  double load_velocity;
  /**
   * Torque-forming current, A.
   */
  double current_a;
  /**
   * Torque of the motor, N m.
   */
  double torque_nm;
  /**
   * What the shaft does to the load, N, or N m at a load that turns.
   */
  double shaft_force;
  /**
   * The compensator's estimate of motor minus load; NaN without one.
   */
  double gap_estimate;
  /**
   * Its estimate of the inertia that the motor carries, kg m2; NaN without one.
   */
  double inertia_estimate_kgm2;
  /**
   * Its estimate of the shaft's stiffness, N m/rad; NaN without one.
   */
  double stiffness_estimate_nm_per_rad;
  /**
   * Its estimate of the shaft's damping, N m s/rad; NaN without one.
   */
  double damping_estimate_nm_s_per_rad;
  /**
   * Flank of the gap in contact: -1, 0 or 1.
   */
  int32_t engagement;
  /**
   * The compensator's estimate of it.
   */
  int32_t engagement_estimate;
} LmAxisSample;

/**
 * What went wrong in the last call of this thread that did not answer `LM_STATUS_OK`.
 */
typedef struct LmError {
  /**
   * What that call answered; `LM_STATUS_OK` where none has failed.
   */
  enum LmStatus status;
  /**
   * Stable name of the reason.
   */
  const char *code;
  /**
   * What is wrong, with place and values.
   */
  const char *message;
  /**
   * What to do; may be empty.
   */
  const char *hint;
  /**
   * File of the first finding; empty without one.
   */
  const char *file;
  /**
   * Its line, from 1; 0 without a place.
   */
  uint32_t line;
  /**
   * Its column in bytes, from 1; 0 without a place.
   */
  uint32_t column;
  /**
   * How many findings there are (`lm_error_finding`).
   */
  size_t findings;
} LmError;

/**
 * Something that was found in a program or a machine file, with its place.
 */
typedef struct LmFinding {
  /**
   * Stable name of the kind of finding.
   */
  const char *code;
  /**
   * What was found, with values.
   */
  const char *message;
  /**
   * What to do; may be empty.
   */
  const char *hint;
  /**
   * Name of the file.
   */
  const char *file;
  /**
   * The line that it is about; may be empty.
   */
  const char *excerpt;
  /**
   * The key of a machine file that it is about; empty for a program.
   */
  const char *key;
  /**
   * Whether it refuses the program or the machine.
   */
  bool is_error;
  /**
   * Line, from 1; 0 for the file as a whole.
   */
  uint32_t line;
  /**
   * Column in bytes, from 1; 0 where there is none.
   */
  uint32_t column;
  /**
   * Length in bytes.
   */
  uint32_t length;
} LmFinding;

/**
 * A log of an axis: columns of equal length, positions in its unit at the load.
 */
typedef struct LmLog {
  /**
   * Unit of the positions: "mm", "deg" or "rad".
   */
  const char *unit;
  /**
   * Rows.
   */
  size_t count;
  /**
   * Times, s, all the same step apart.
   */
  const double *time_s;
  /**
   * Motor.
   */
  const double *motor;
  /**
   * Load; null to do without it.
   */
  const double *load;
  /**
   * Torque-forming current, A.
   */
  const double *current_a;
} LmLog;

/**
 * What a log tells of the gap, in the unit of the log.
 */
typedef struct LmFit {
  /**
   * Total gap at the load.
   */
  double gap;
  /**
   * Lower end of its interval of 95 %.
   */
  double gap_low;
  /**
   * Upper end.
   */
  double gap_high;
  /**
   * Whether the log tells the gap from zero.
   */
  bool excited;
} LmFit;

/**
 * A log of an axis and of what drives it: columns of equal length, positions in its unit at the load.
 */
typedef struct LmBodyLog {
  /**
   * Unit of the positions: "mm", "deg" or "rad".
   */
  const char *unit;
  /**
   * Rows.
   */
  size_t count;
  /**
   * Times, s.
   */
  const double *time_s;
  /**
   * Motor.
   */
  const double *motor;
  /**
   * Load; null where it was not logged.
   */
  const double *load;
  /**
   * Commanded position; null where it was not logged.
   */
  const double *command;
  /**
   * What drives the axis, force, torque, current or voltage in any unit; null where it was not
   * logged.
   */
  const double *drive;
} LmBodyLog;

/**
 * A canonical operation, and the block that it comes from.
 */
typedef struct LmOperation {
  /**
   * The operation: `STRAIGHT_FEED(10.0000, ...)`.
   */
  const char *text;
  /**
   * Line, from 1; 0 for what holds before the first block.
   */
  uint32_t line;
  /**
   * Column in bytes, from 1; 0 for what holds before the first block.
   */
  uint32_t column;
  /**
   * 0 for the program, n for the nth file of subroutines.
   */
  uint32_t file;
} LmOperation;

/**
 * Distribution of an error's magnitude, um.
 */
typedef struct LmErrorStats {
  /**
   * Number of samples.
   */
  uint64_t samples;
  /**
   * Largest magnitude.
   */
  double max;
  /**
   * Root mean square.
   */
  double rms;
  /**
   * Median.
   */
  double p50;
  /**
   * 95th percentile.
   */
  double p95;
  /**
   * 99th percentile.
   */
  double p99;
  /**
   * 99.9th percentile.
   */
  double p999;
} LmErrorStats;

/**
 * What is known of a plan.
 */
typedef struct LmPlan {
  /**
   * Length of the motion, s.
   */
  double duration_s;
  /**
   * Length of cutting moves, mm.
   */
  double cutting_mm;
  /**
   * Length of rapids, mm.
   */
  double rapid_mm;
  /**
   * Distance of the command itself from the programmed path on cutting moves, um: zeros where only
   * the plan was asked for.
   */
  struct LmErrorStats command;
} LmPlan;

/**
 * The answer of a run.
 */
typedef struct LmRunInfo {
  /**
   * Name of the method that is recommended; null where none is.
   */
  const char *recommended;
  /**
   * Tolerance of the verdict, um.
   */
  double tolerance_um;
  /**
   * The plan.
   */
  struct LmPlan plan;
  /**
   * The same machine without any gap and without compensation.
   */
  struct LmErrorStats without_gap;
  /**
   * Number of methods.
   */
  size_t results;
  /**
   * Whether the method that decides keeps the tolerance: of several the recommended one.
   */
  bool within_tolerance;
} LmRunInfo;

/**
 * How one method did.
 */
typedef struct LmMethodResult {
  /**
   * Its name.
   */
  const char *method;
  /**
   * Contour error of cutting moves.
   */
  struct LmErrorStats cutting;
  /**
   * Contour error of rapids.
   */
  struct LmErrorStats rapid;
  /**
   * What backlash adds to the error on cutting moves.
   */
  struct LmErrorStats backlash;
  /**
   * Blocks that the list of the worst has (`lm_run_worst_block`).
   */
  size_t worst_blocks;
  /**
   * Number of all reversals.
   */
  uint64_t reversals;
  /**
   * Whether the largest error of cutting moves is within the tolerance, and the machine not
   * stopped.
   */
  bool within_tolerance;
  /**
   * Whether the control stops the machine.
   */
  bool stopped;
} LmMethodResult;

/**
 * A block of the program, and how far the tool left its contour.
 */
typedef struct LmBlock {
  /**
   * Its text, trimmed, at most 80 characters.
   */
  const char *text;
  /**
   * What makes most of the error, for people.
   */
  const char *cause;
  /**
   * Running number of the move.
   */
  uint64_t segment;
  /**
   * Time of the worst sample, s.
   */
  double time_s;
  /**
   * Largest error, um, signed: positive to the left of the direction of travel.
   */
  double max_um;
  /**
   * Root mean square, um.
   */
  double rms_um;
  /**
   * Part of the command itself (blending) in the largest error, um.
   */
  double command_um;
  /**
   * Part that a machine without a gap would add, um.
   */
  double servo_um;
  /**
   * Part of the gap, um.
   */
  double backlash_um;
  /**
   * Commanded tip at the worst sample, mm, from the program's zero.
   */
  double at_mm[3];
  /**
   * File: 0 for the program, from 1 those of its subroutines.
   */
  uint32_t file;
  /**
   * Line, from 1.
   */
  uint32_t line;
  /**
   * Column in bytes, from 1.
   */
  uint32_t column;
  /**
   * Whether it is a G0 move.
   */
  bool rapid;
} LmBlock;

/**
 * How far a run is.
 */
typedef struct LmProgress {
  /**
   * Bytes of the program read so far.
   */
  uint64_t done_bytes;
  /**
   * Bytes of the program.
   */
  uint64_t total_bytes;
  /**
   * Machine time so far, s.
   */
  double simulated_s;
  /**
   * Part of the program that has been read, 0 to 1.
   */
  double share;
} LmProgress;

/**
 * Is told how far a run is, about once a second of motion; false ends it.
 */
typedef bool (*LmOnProgress)(void *user,
                             const struct LmProgress *progress);

/**
 * A servo tick of the contour as the machine cut it; places in mm from the program's zero.
 */
typedef struct LmContourSample {
  /**
   * Time, s.
   */
  double time_s;
  /**
   * Contour error, um: positive to the left of the direction of travel.
   */
  double error_um;
  /**
   * What backlash adds to it, um.
   */
  double backlash_um;
  /**
   * Foot point on the programmed path.
   */
  double foot_mm[3];
  /**
   * Unit vector to the left of travel in the plane in force.
   */
  double normal[3];
  /**
   * Commanded tip.
   */
  double commanded_mm[3];
  /**
   * Actual tip.
   */
  double actual_mm[3];
  /**
   * Unit vector along the tool, from its tip to the spindle.
   */
  double tool[3];
  /**
   * Line of the block, from 1.
   */
  uint32_t line;
  /**
   * Whether any joint is commanded to move; the others are not judged.
   */
  bool moving;
  /**
   * Whether the tool is on a G0 move.
   */
  bool rapid;
} LmContourSample;

/**
 * Takes samples of a method (its number in the order of the methods); false ends the run. They are
 * valid until it returns.
 */
typedef bool (*LmOnContour)(void *user,
                            size_t method,
                            const struct LmContourSample *samples,
                            size_t count);

/**
 * A motor at a servo tick, in the unit of its axis.
 */
typedef struct LmMotorSample {
  /**
   * Time, s.
   */
  double time_s;
  /**
   * Reference of the servo.
   */
  double reference;
  /**
   * Motor, at the load's side of the transmission.
   */
  double motor;
  /**
   * Load.
   */
  double load;
  /**
   * Torque-forming current, A.
   */
  double current_a;
  /**
   * Torque, N m.
   */
  double torque_nm;
  /**
   * Flank of the gap in contact: -1, 0 or 1.
   */
  int32_t engagement;
  /**
   * Letter of the axis.
   */
  char axis;
  /**
   * Whether it is the second motor of a gantry.
   */
  bool second;
} LmMotorSample;

/**
 * Takes the motors of a method, for each tick those of all axes; as `LmOnContour`.
 */
typedef bool (*LmOnMotors)(void *user,
                           size_t method,
                           const struct LmMotorSample *samples,
                           size_t count);

/**
 * Takes finished blocks of a method, in their order; as `LmOnContour`.
 */
typedef bool (*LmOnBlocks)(void *user,
                           size_t method,
                           const struct LmBlock *blocks,
                           size_t count);

/**
 * A reversal of an axis.
 */
typedef struct LmReversal {
  /**
   * When the commanded velocity changes its sign, s.
   */
  double time_s;
  /**
   * Largest contour error until the end of its window, um, signed.
   */
  double peak_um;
  /**
   * Share of backlash in it, um, signed.
   */
  double backlash_um;
  /**
   * Line of the block in force, from 1.
   */
  uint32_t line;
  /**
   * New direction: 1 or -1.
   */
  int32_t direction;
  /**
   * Letter of the axis.
   */
  char axis;
  /**
   * Whether it is on a rapid.
   */
  bool rapid;
} LmReversal;

/**
 * Takes finished reversals of a method, in their order; as `LmOnContour`.
 */
typedef bool (*LmOnReversals)(void *user,
                              size_t method,
                              const struct LmReversal *reversals,
                              size_t count);

/**
 * A sample of the plan, one a command cycle: mm and deg of the joints X Y Z A B C U V W; zeros where
 * the machine has none. A joint that turns is in deg whatever its letter.
 */
typedef struct LmPlanSample {
  /**
   * Time, s.
   */
  double time_s;
  /**
   * Position.
   */
  double position[9];
  /**
   * Velocity per s.
   */
  double velocity[9];
  /**
   * Acceleration per s2.
   */
  double acceleration[9];
  /**
   * Line of the block, from 1.
   */
  uint32_t line;
} LmPlanSample;

/**
 * Takes samples of the plan; false ends it. They are valid until it returns.
 */
typedef bool (*LmOnPlan)(void *user,
                         const struct LmPlanSample *samples,
                         size_t count);

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Version of the library, for example "0.1.0".
 *
 * Threads: any. Real time: yes.
 */
const char *lm_version(void);

/**
 * Version of the interface of the library at hand: equal to `LM_ABI` of the header, or the two do
 * not fit.
 *
 * Threads: any. Real time: yes.
 */
uint32_t lm_abi(void);

/**
 * Handles that were made and not freed: 0 at the end of a program that frees all.
 *
 * Threads: any. Real time: yes.
 */
size_t lm_handles(void);

/**
 * An axis of a machine with a registered method ("none", "fixed", "adaptive", ..), standing still at
 * `start` in its unit. With `differences` positions alone are enough: velocity and acceleration are
 * made from them; without it the drive interpolates by its own law, which may need both.
 *
 * All memory that stepping may ever need is taken here: a few kB; 320 kB for "adaptive"; 45 bytes for each
 * ms of its `memory_s` for "iterative-learning", 2.7 MB for the usual 60 s. When that is full the strokes
 * that were not used for the longest time are forgotten.
 *
 * Threads: any. Real time: no; what comes after it is.
 *
 * # Safety
 * `drive` and `method` are null or end with a zero; `axis` is null or has room.
 */
enum LmStatus lm_axis_new(const struct LmMachine *machine,
                          const char *drive,
                          const char *method,
                          double start,
                          bool differences,
                          struct LmAxis **axis);

/**
 * As `lm_axis_new`, of a description alone: the name of one that comes with the library ("paper",
 * "vmc3:x"), or the text of an axis file.
 *
 * Threads: any. Real time: no; what comes after it is.
 *
 * # Safety
 * `description` and `method` are null or end with a zero; `axis` is null or has room.
 */
enum LmStatus lm_axis_from_description(const char *description,
                                       const char *method,
                                       double start,
                                       bool differences,
                                       struct LmAxis **axis);

/**
 * As `lm_axis_new`, with a compensator of the caller's own. It is stepped by whoever steps the axis,
 * and is as fit for real time as its `step` is.
 *
 * Threads: any. Real time: no; what comes after it is.
 *
 * # Safety
 * `drive` is null or ends with a zero; `compensator` is null or as `LmCompensator` says; `axis` is
 * null or has room.
 */
enum LmStatus lm_axis_with_compensator(const struct LmMachine *machine,
                                       const char *drive,
                                       const struct LmCompensator *compensator,
                                       double start,
                                       bool differences,
                                       struct LmAxis **axis);

/**
 * What is fixed of an axis.
 *
 * Threads: one at a time. Real time: yes.
 *
 * # Safety
 * `info` is null or has room.
 */
enum LmStatus lm_axis_info(struct LmAxis *axis,
                           struct LmAxisInfo *info);

/**
 * Takes the setpoint of a command cycle and steps its servo ticks: `samples` has room for `count`,
 * which is `LmAxisInfo.servo_ticks`. Sample k shows the axis before that tick's command acts.
 *
 * A setpoint that is refused leaves the axis as it was.
 *
 * Threads: one at a time. Real time: yes.
 *
 * # Safety
 * `setpoint` is null or a setpoint; `samples` is null or has room for `count`.
 */
enum LmStatus lm_axis_step(struct LmAxis *axis,
                           const struct LmSetpoint *setpoint,
                           struct LmAxisSample *samples,
                           size_t count);

/**
 * Takes `count` setpoints, one a command cycle, and steps their servo ticks: `samples` has room for
 * `sample_count`, which is `count` times `LmAxisInfo.servo_ticks`.
 *
 * Setpoints before a refused one have been taken, and their samples are there.
 *
 * Threads: one at a time. Real time: yes.
 *
 * # Safety
 * `setpoints` is null or has `count`; `samples` is null or has room for `sample_count`.
 */
enum LmStatus lm_axis_push(struct LmAxis *axis,
                           const struct LmSetpoint *setpoints,
                           size_t count,
                           struct LmAxisSample *samples,
                           size_t sample_count);

/**
 * Takes the setpoint of a command cycle, whose servo ticks `lm_axis_tick` steps one by one: for a
 * thread that runs at the servo's rate.
 *
 * Threads: one at a time. Real time: yes.
 *
 * # Safety
 * `setpoint` is null or a setpoint.
 */
enum LmStatus lm_axis_setpoint(struct LmAxis *axis,
                               const struct LmSetpoint *setpoint);

/**
 * Steps one servo tick of the setpoint that was taken last.
 *
 * Threads: one at a time. Real time: yes.
 *
 * # Safety
 * `sample` is null or has room.
 */
enum LmStatus lm_axis_tick(struct LmAxis *axis,
                           struct LmAxisSample *sample);

/**
 * A copy that goes on from here on its own, and is as fit for real time.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * `copy` is null or has room.
 */
enum LmStatus lm_axis_copy(struct LmAxis *axis,
                           struct LmAxis **copy);

/**
 * Frees an axis; nothing for a null.
 *
 * Threads: any, when no other uses it. Real time: no.
 */
enum LmStatus lm_axis_free(struct LmAxis *axis);

/**
 * What went wrong last in this thread. The texts are valid until the next call of this thread that
 * fails, or `lm_error_clear`.
 *
 * Threads: any; each has its own. Real time: no.
 *
 * # Safety
 * `error` is null or has room.
 */
enum LmStatus lm_error(struct LmError *error);

/**
 * A finding of what went wrong last in this thread; its texts are valid as those of `lm_error`.
 *
 * Threads: any; each has its own. Real time: no.
 *
 * # Safety
 * `finding` is null or has room.
 */
enum LmStatus lm_error_finding(size_t index,
                               struct LmFinding *finding);

/**
 * Forgets what went wrong last in this thread. A thread that has called it once has all that its
 * errors need: call it before a real-time loop.
 *
 * Threads: any; each has its own. Real time: no.
 */
void lm_error_clear(void);

/**
 * Finds the gap in a log. With `machine` and `drive` motor data are known and the interval is
 * narrower; `machine` may be null. `document` becomes all that was found, as the command writes it;
 * it may be null.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `log` is null or a log whose columns are null or have `count` numbers; `drive` is null or ends with
 * a zero; `fit` and `document` are null or have room.
 */
enum LmStatus lm_fit(const struct LmLog *log,
                     const struct LmMachine *machine,
                     const char *drive,
                     struct LmFit *fit,
                     struct LmText **document);

/**
 * Finds what a log tells of an axis as one body: inertia, friction, gains of the servo, how position
 * is lost after a reversal. `document` becomes a JSON object of what was found, in m or rad and the
 * log's unit of what drives the axis; `untold` in it says what is not told, and why.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `log` is null or a log whose columns are null or have `count` numbers; `document` is null or has
 * room.
 */
enum LmStatus lm_identify(const struct LmBodyLog *log,
                          struct LmText **document);

/**
 * A machine that comes with the library: "vmc3", "vmc3-worn", "bench3" and others.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `name` is null or ends with a zero; `machine` is null or has room.
 */
enum LmStatus lm_machine_preset(const char *name,
                                struct LmMachine **machine);

/**
 * Name of a machine that comes with the library, and a line about it for people, by its number from
 * 0; `LM_STATUS_SIZE` behind the last one. The texts are constant.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `name` and `summary` are null or have room.
 */
enum LmStatus lm_preset(size_t index,
                        const char **name,
                        const char **summary);

/**
 * A machine from the text of a machine file; `name` is for messages.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `name` and `toml` are null or end with a zero; `machine` is null or has room.
 */
enum LmStatus lm_machine_from_toml(const char *name,
                                   const char *toml,
                                   struct LmMachine **machine);

/**
 * A machine from a JSON object with the keys of machine files, as a program makes it.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `json` is null or ends with a zero; `machine` is null or has room.
 */
enum LmStatus lm_machine_from_json(const char *json,
                                   struct LmMachine **machine);

/**
 * A machine from a file.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `path` is null or ends with a zero; `machine` is null or has room.
 */
enum LmStatus lm_machine_from_file(const char *path,
                                   struct LmMachine **machine);

/**
 * Another machine, with `count` keys of the first one changed: `keys[i]` is a key of machine files,
 * for example "axis.x.load.slide.gap_um", `values[i]` its value as it stands in one, for example
 * "25.0" or "\"quintic\"".
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `keys` and `values` are null or have `count` texts that end with a zero; `edited` is null or has
 * room.
 */
enum LmStatus lm_machine_edit(const struct LmMachine *machine,
                              const char *const *keys,
                              const char *const *values,
                              size_t count,
                              struct LmMachine **edited);

/**
 * A machine from what a control is configured with or another program knows: LinuxCNC's INI
 * ("linuxcnc"), grbl's settings ("grbl"), a machine of FreeCAD ("freecad"), URDF ("urdf") and others;
 * an unknown `format` is answered with the list. `format` may be null where name or text tell it; what
 * is not described is taken from `preset`, or from the usual machine if that is null; `tip` is the link
 * of the tool in a URDF, or null. `file` becomes the machine's file, in which every value says where it is from; it may be
 * null.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * The texts are null or end with a zero; `machine` and `file` are null or have room.
 */
enum LmStatus lm_machine_import(const char *name,
                                const char *description,
                                const char *format,
                                const char *preset,
                                const char *tip,
                                struct LmMachine **machine,
                                struct LmText **file);

/**
 * All that is wrong with the text of a machine file, tuning included; an empty list for one that
 * holds.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `name` and `toml` are null or end with a zero; `found` is null or has room.
 */
enum LmStatus lm_machine_problems(const char *name,
                                  const char *toml,
                                  struct LmFindings **found);

/**
 * The machine as the text of a machine file.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `text` is null or has room.
 */
enum LmStatus lm_machine_toml(const struct LmMachine *machine,
                              struct LmText **text);

/**
 * The machine as a JSON object with the keys of machine files, which `lm_machine_from_json` takes.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `document` is null or has room.
 */
enum LmStatus lm_machine_json(const struct LmMachine *machine,
                              struct LmText **document);

/**
 * What a commissioning engineer would object to, a line each; empty where there is nothing.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `remarks` is null or has room.
 */
enum LmStatus lm_machine_remarks(const struct LmMachine *machine,
                                 struct LmText **remarks);

/**
 * A number of the machine's file, by its key: "axis.x.load.slide.gap_um".
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `key` is null or ends with a zero; `number` is null or has room.
 */
enum LmStatus lm_machine_number(const struct LmMachine *machine,
                                const char *key,
                                double *number);

/**
 * Frees a machine; nothing for a null. Simulations and axes of it go on.
 *
 * Threads: any, when no other uses it. Real time: no.
 */
enum LmStatus lm_machine_free(struct LmMachine *machine);

/**
 * A program of `length` bytes of G-code, which are copied; `name` is for messages.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `name` is null or ends with a zero; `code` is null or has `length` bytes; `program` is null or has
 * room.
 */
enum LmStatus lm_program_from_text(const char *name,
                                   const char *code,
                                   size_t length,
                                   struct LmProgram **program);

/**
 * A program in a file, which is read again by each run.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `path` is null or ends with a zero; `program` is null or has room.
 */
enum LmStatus lm_program_from_file(const char *path,
                                   struct LmProgram **program);

/**
 * Frees a program; nothing for a null. Simulations of it go on.
 *
 * Threads: any, when no other uses it. Real time: no.
 */
enum LmStatus lm_program_free(struct LmProgram *program);

/**
 * What is wrong with a program, with `lints` also what is allowed and may break something.
 *
 * `machine` may be null; its dialect, tools and parameters are used otherwise. `settings` may be
 * null, or is a JSON object with the settings of `lm_simulation_set` that say how a program is read.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `settings` is null or ends with a zero; `found` is null or has room.
 */
enum LmStatus lm_program_findings(const struct LmProgram *program,
                                  const struct LmMachine *machine,
                                  const char *settings,
                                  bool lints,
                                  struct LmFindings **found);

/**
 * What a line does, for people. `machine` and `settings` as for `lm_program_findings`.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `settings` is null or ends with a zero; `explanation` is null or has room.
 */
enum LmStatus lm_program_explain(const struct LmProgram *program,
                                 const struct LmMachine *machine,
                                 const char *settings,
                                 uint32_t line,
                                 struct LmText **explanation);

/**
 * The program in one style: words in upper case, apart from each other, subroutines indented.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `formatted` is null or has room.
 */
enum LmStatus lm_program_format(const struct LmProgram *program,
                                struct LmText **formatted);

/**
 * What interpreter and lints find in a program, in the order of its text. `levels` is a JSON object of
 * levels ("allow", "warn", "deny") by the code of a lint, for example {"all": "deny"}; null for the
 * usual ones. `machine` and `settings` as for `lm_program_findings`.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `settings` and `levels` are null or end with a zero; `found` is null or has room.
 */
enum LmStatus lm_program_lint(const struct LmProgram *program,
                              const struct LmMachine *machine,
                              const char *settings,
                              const char *levels,
                              struct LmFindings **found);

/**
 * Starts to read a program's canonical operations, which `lm_operations_next` gives. `machine` and
 * `settings` as for `lm_program_findings`.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `settings` is null or ends with a zero; `operations` is null or has room.
 */
enum LmStatus lm_program_operations(const struct LmProgram *program,
                                    const struct LmMachine *machine,
                                    const char *settings,
                                    struct LmOperations **operations);

/**
 * The next operation. Its text is valid until the next call with these operations; null at the end.
 * Where there was something wrong on the way, the end is answered with `LM_STATUS_PROGRAM`.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * `operation` is null or has room.
 */
enum LmStatus lm_operations_next(struct LmOperations *operations,
                                 struct LmOperation *operation);

/**
 * Frees operations; nothing for a null.
 *
 * Threads: any, when no other uses it. Real time: no.
 */
enum LmStatus lm_operations_free(struct LmOperations *operations);

/**
 * The program in a style of one's own: `style` is a JSON object with "case" ("upper", "lower",
 * "keep"), "indent" (blanks for each level of O-words) and "line_numbers" ("keep", "remove", or the
 * step of new ones as a text); what is left out is as in `lm_program_format`.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `style` is null or ends with a zero; `formatted_text` is null or has room.
 */
enum LmStatus lm_program_format_as(const struct LmProgram *program,
                                   const char *style,
                                   struct LmText **formatted_text);

/**
 * The program with everything computed: no parameters, loops, calls, cycles, offsets. `system` is the
 * work coordinate system of the coordinates, 1 for G54 to 9 for G59.3; `machine` and `settings` as for
 * `lm_program_findings`.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `settings` is null or ends with a zero; `resolved_text` is null or has room.
 */
enum LmStatus lm_program_resolved(const struct LmProgram *program,
                                  const struct LmMachine *machine,
                                  const char *settings,
                                  uint8_t system,
                                  struct LmText **resolved_text);

/**
 * What a line does, as data: the JSON document of `lostmotion gcode explain`. `machine` and `settings`
 * as for `lm_program_findings`.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `settings` is null or ends with a zero; `document` is null or has room.
 */
enum LmStatus lm_program_explain_json(const struct LmProgram *program,
                                      const struct LmMachine *machine,
                                      const char *settings,
                                      uint32_t line,
                                      struct LmText **document);

/**
 * The answer of a run; its texts are valid until the run is freed.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `info` is null or has room.
 */
enum LmStatus lm_run_info(const struct LmRun *run,
                          struct LmRunInfo *info);

/**
 * How a method did, by its number in the order of the methods; its name is valid until the run is
 * freed.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `result` is null or has room.
 */
enum LmStatus lm_run_result(const struct LmRun *run,
                            size_t index,
                            struct LmMethodResult *result);

/**
 * One of a method's blocks with the largest errors, worst first; its texts are valid until the run
 * is freed.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `block` is null or has room.
 */
enum LmStatus lm_run_worst_block(const struct LmRun *run,
                                 size_t method,
                                 size_t index,
                                 struct LmBlock *block);

/**
 * Any figure of the run in full, by its place in the document as a JSON pointer:
 * "/results/0/cutting/max", "/plan/duration_s". NaN for one that is not known (null).
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `pointer` is null or ends with a zero; `number` is null or has room.
 */
enum LmStatus lm_run_number(const struct LmRun *run,
                            const char *pointer,
                            double *number);

/**
 * The document that the command prints with `--format json`.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `document` is null or has room.
 */
enum LmStatus lm_run_json(const struct LmRun *run,
                          struct LmText **document);

/**
 * The answer for people, as the command prints it.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `answer` is null or has room.
 */
enum LmStatus lm_run_text(const struct LmRun *run,
                          struct LmText **answer);

/**
 * The page of the run for a browser, where `lm_simulation_keep_page` asked for it.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `html` is null or has room.
 */
enum LmStatus lm_run_page(const struct LmRun *run,
                          struct LmText **html);

/**
 * What the last method that learns has learned of the axes, as the text of a file for the setting
 * `learned`; empty where none has.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `toml` is null or has room.
 */
enum LmStatus lm_run_learned(const struct LmRun *run,
                             struct LmText **toml);

/**
 * Frees a run; nothing for a null.
 *
 * Threads: any, when no other uses it. Real time: no.
 */
enum LmStatus lm_run_free(struct LmRun *run);

/**
 * A program on a machine, each axis with the method that the machine names for it, everything else
 * as the machine has it. Both may be freed afterwards.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `simulation` is null or has room.
 */
enum LmStatus lm_simulation_new(const struct LmProgram *program,
                                const struct LmMachine *machine,
                                struct LmSimulation **simulation);

/**
 * Name of a registered compensation method, and a line about it for people, by its number from 0;
 * `LM_STATUS_SIZE` behind the last one. The texts are constant.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `name` and `summary` are null or have room.
 */
enum LmStatus lm_method(size_t index,
                        const char **name,
                        const char **summary);

/**
 * Adds a registered compensation method for all axes; several are compared on one plan.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * `name` is null or ends with a zero.
 */
enum LmStatus lm_simulation_method(struct LmSimulation *simulation,
                                   const char *name);

/**
 * Adds a compensator of the caller's own for all axes.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * `compensator` is null or as `LmCompensator` says; its functions and `user` outlive the simulation.
 */
enum LmStatus lm_simulation_compensator(struct LmSimulation *simulation,
                                        const struct LmCompensator *compensator);

/**
 * Sets a setting that is a number: `tolerance_um`, `cutting_force_n`, `bow_limit_um`, `sensitivity`
 * (percent), `max_duration_s`, `keep_blocks`, `keep_reversals`, `spline_tolerance_mm`, `threads` (1,
 * the default: the calling thread alone; 0: one per core).
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * `key` is null or ends with a zero.
 */
enum LmStatus lm_simulation_set(struct LmSimulation *simulation,
                                const char *key,
                                double number);

/**
 * Sets a setting that is a text: `dialect`, `control`, `quality` ("fast", "optimal"), `tool_table`
 * and `learned` (the texts of the files).
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * `key` and `value` are null or end with a zero.
 */
enum LmStatus lm_simulation_set_text(struct LmSimulation *simulation,
                                     const char *key,
                                     const char *value);

/**
 * Sets a setting that is a list or a table, in JSON: `accept`, `refuse`, `subroutines` (lists of
 * texts), `m_codes` ({"M10": "dwell:1.5"}), `block_skips` ([1, 2]), `told` ({"3011": 20260101}),
 * `limits` ({"nesting": 20}), `interventions` ([[3.2, "hold", null], [4.0, "override", 0.5]]).
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * `key` and `json` are null or end with a zero.
 */
enum LmStatus lm_simulation_set_json(struct LmSimulation *simulation,
                                     const char *key,
                                     const char *json);

/**
 * Whether the run keeps what its page needs (`lm_run_page`).
 *
 * Threads: one at a time. Real time: no.
 */
enum LmStatus lm_simulation_keep_page(struct LmSimulation *simulation,
                                      bool keep);

/**
 * Sets who is told the progress; null for nobody. Callbacks of a run come one at a time: on the
 * calling thread where the setting `threads` is 1, which it is by default, else on one of the run's.
 * They must return: no `longjmp`, no C++ exception.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * The function takes `user` from any thread, as long as the simulation lives.
 */
enum LmStatus lm_simulation_on_progress(struct LmSimulation *simulation,
                                        LmOnProgress function,
                                        void *user);

/**
 * Sets who takes contour errors of all servo ticks; as `lm_simulation_on_progress`.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * As for `lm_simulation_on_progress`.
 */
enum LmStatus lm_simulation_on_contour(struct LmSimulation *simulation,
                                       LmOnContour function,
                                       void *user);

/**
 * Sets who takes the signals of all motors at all servo ticks; as `lm_simulation_on_progress`.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * As for `lm_simulation_on_progress`.
 */
enum LmStatus lm_simulation_on_motors(struct LmSimulation *simulation,
                                      LmOnMotors function,
                                      void *user);

/**
 * Sets who takes all blocks as they are finished; as `lm_simulation_on_progress`.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * As for `lm_simulation_on_progress`.
 */
enum LmStatus lm_simulation_on_blocks(struct LmSimulation *simulation,
                                      LmOnBlocks function,
                                      void *user);

/**
 * Sets who takes all reversals as they are finished; as `lm_simulation_on_progress`.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * As for `lm_simulation_on_progress`.
 */
enum LmStatus lm_simulation_on_reversals(struct LmSimulation *simulation,
                                         LmOnReversals function,
                                         void *user);

/**
 * Sets who takes the samples of `lm_simulation_plan`; as `lm_simulation_on_progress`.
 *
 * Threads: one at a time. Real time: no.
 *
 * # Safety
 * As for `lm_simulation_on_progress`.
 */
enum LmStatus lm_simulation_on_plan(struct LmSimulation *simulation,
                                    LmOnPlan function,
                                    void *user);

/**
 * Runs the program and judges the contour error of each method. The simulation may run again.
 *
 * Threads: any, one run at a time; others may cancel it. Real time: no.
 *
 * # Safety
 * `run` is null or has room.
 */
enum LmStatus lm_simulation_run(const struct LmSimulation *simulation,
                                struct LmRun **run);

/**
 * Plans the motion alone; samples go to `lm_simulation_on_plan`.
 *
 * Threads: as `lm_simulation_run`. Real time: no.
 *
 * # Safety
 * `plan` is null or has room.
 */
enum LmStatus lm_simulation_plan(const struct LmSimulation *simulation,
                                 struct LmPlan *plan);

/**
 * Reads the program to its end and holds it against the machine, without moving anything.
 *
 * Threads: as `lm_simulation_run`. Real time: no.
 */
enum LmStatus lm_simulation_check(const struct LmSimulation *simulation);

/**
 * Ends the run that is going on, at its next second of motion; nothing where there is none.
 *
 * Threads: any. Real time: yes.
 */
enum LmStatus lm_simulation_cancel(const struct LmSimulation *simulation);

/**
 * Frees a simulation; nothing for a null. Its runs stay.
 *
 * Threads: any, when it does not run. Real time: no.
 */
enum LmStatus lm_simulation_free(struct LmSimulation *simulation);

/**
 * The characters of a text, valid until it is freed, and how many bytes they are without the zero
 * at their end; `length` may be null.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `characters` is null or has room; so has `length`.
 */
enum LmStatus lm_text(const struct LmText *text,
                      const char **characters,
                      size_t *length);

/**
 * Frees a text; nothing for a null.
 *
 * Threads: any, when no other uses it. Real time: no.
 */
enum LmStatus lm_text_free(struct LmText *text);

/**
 * How many findings there are.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `count` is null or has room.
 */
enum LmStatus lm_findings_count(const struct LmFindings *findings,
                                size_t *count);

/**
 * A finding; its texts are valid until the list is freed.
 *
 * Threads: any. Real time: no.
 *
 * # Safety
 * `finding` is null or has room.
 */
enum LmStatus lm_findings_get(const struct LmFindings *findings,
                              size_t index,
                              struct LmFinding *finding);

/**
 * Frees a list of findings; nothing for a null.
 *
 * Threads: any, when no other uses it. Real time: no.
 */
enum LmStatus lm_findings_free(struct LmFindings *findings);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LOSTMOTION_H */
