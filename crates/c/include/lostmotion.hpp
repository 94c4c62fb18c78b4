/*
 * lostmotion for C++17: lostmotion.h with objects that free themselves, exceptions, strings and lambdas.
 *
 * Objects move and do not copy. Whatever fails throws lostmotion::Error; what a callback throws ends the
 * run and comes out of it. Axis::step, setpoint and tick throw only where they are misused, and are as
 * fit for real time as the functions behind them. Threads are as lostmotion.h says.
 */

#ifndef LOSTMOTION_HPP
#define LOSTMOTION_HPP

#include "lostmotion.h"

#include <cstddef>
#include <exception>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace lostmotion {

/** Something that was found in a program or a machine file. */
struct Finding {
    std::string code, message, hint, file, excerpt, key;
    bool is_error = false;
    unsigned line = 0, column = 0, length = 0;

    explicit Finding(const LmFinding &found)
        : code(found.code), message(found.message), hint(found.hint), file(found.file),
          excerpt(found.excerpt), key(found.key), is_error(found.is_error), line(found.line),
          column(found.column), length(found.length)
    {
    }
};

/** Why a call has failed. */
class Error : public std::runtime_error {
  public:
    /** Of the last call of this thread. */
    static Error last()
    {
        LmError error{};
        (void)lm_error(&error);
        return Error(error);
    }

    LmStatus status;
    std::string code, hint, file;
    unsigned line, column;
    std::vector<Finding> findings;

  private:
    explicit Error(const LmError &error)
        : std::runtime_error(error.message), status(error.status), code(error.code),
          hint(error.hint), file(error.file), line(error.line), column(error.column)
    {
        for (std::size_t index = 0; index < error.findings; index++) {
            LmFinding found;
            if (lm_error_finding(index, &found) == LM_STATUS_OK)
                findings.emplace_back(found);
        }
    }
};

/** Throws where a call has failed. */
inline void check(LmStatus status)
{
    if (status != LM_STATUS_OK)
        throw Error::last();
}

/** A handle that frees itself. */
template <typename T, LmStatus (*Free)(T *)> class Handle {
  public:
    Handle() = default;
    Handle(Handle &&other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
    Handle &operator=(Handle &&other) noexcept
    {
        Handle taken(std::move(other));
        std::swap(handle_, taken.handle_);
        return *this;
    }
    Handle(const Handle &) = delete;
    Handle &operator=(const Handle &) = delete;
    ~Handle() { (void)Free(handle_); }

    /** The handle, for functions of lostmotion.h. */
    T *get() const { return handle_; }
    /** Where a function of lostmotion.h puts a handle. */
    T **put() { return &handle_; }

  private:
    T *handle_ = nullptr;
};

/** A text of the library as a string. */
class Text : public Handle<LmText, lm_text_free> {
  public:
    std::string string() const
    {
        const char *characters = nullptr;
        std::size_t length = 0;
        check(lm_text(get(), &characters, &length));
        return std::string(characters, length);
    }
};

/** A canonical operation, and the block that it comes from. */
struct Operation {
    std::string text;
    unsigned line = 0, column = 0, file = 0;
};

/** A part program. */
class Program : public Handle<LmProgram, lm_program_free> {
  public:
    static Program from_text(const std::string &name, std::string_view code)
    {
        Program program;
        check(lm_program_from_text(name.c_str(), code.data(), code.size(), program.put()));
        return program;
    }

    static Program from_file(const std::string &path)
    {
        Program program;
        check(lm_program_from_file(path.c_str(), program.put()));
        return program;
    }

    /** What interpreter and lints find; `levels` is a JSON object of levels by lint. */
    std::vector<Finding> lint(const std::string &levels = "{}") const
    {
        Handle<LmFindings, lm_findings_free> found;
        check(lm_program_lint(get(), nullptr, nullptr, levels.c_str(), found.put()));
        std::size_t count = 0;
        check(lm_findings_count(found.get(), &count));
        std::vector<Finding> all;
        for (std::size_t index = 0; index < count; index++) {
            LmFinding finding;
            check(lm_findings_get(found.get(), index, &finding));
            all.emplace_back(finding);
        }
        return all;
    }

    /** Canonical operations. Throws at the end of a program with errors. */
    std::vector<Operation> operations() const
    {
        Handle<LmOperations, lm_operations_free> reading;
        check(lm_program_operations(get(), nullptr, nullptr, reading.put()));
        std::vector<Operation> all;
        for (;;) {
            LmOperation found;
            check(lm_operations_next(reading.get(), &found));
            if (!found.text)
                return all;
            all.push_back({found.text, found.line, found.column, found.file});
        }
    }

    /** The program in one style, a JSON object as for `lm_program_format_as`. */
    std::string format(const std::string &style = "{}") const
    {
        Text text;
        check(lm_program_format_as(get(), style.c_str(), text.put()));
        return text.string();
    }

    /** The program with everything computed; `system` is 1 for G54 to 9 for G59.3. */
    std::string resolved(unsigned char system = 1) const
    {
        Text text;
        check(lm_program_resolved(get(), nullptr, nullptr, system, text.put()));
        return text.string();
    }
};

/** A machine: checked, and never changed. */
class Machine : public Handle<LmMachine, lm_machine_free> {
  public:
    static Machine preset(const std::string &name)
    {
        Machine machine;
        check(lm_machine_preset(name.c_str(), machine.put()));
        return machine;
    }

    static Machine from_toml(const std::string &name, const std::string &toml)
    {
        Machine machine;
        check(lm_machine_from_toml(name.c_str(), toml.c_str(), machine.put()));
        return machine;
    }

    static Machine from_file(const std::string &path)
    {
        Machine machine;
        check(lm_machine_from_file(path.c_str(), machine.put()));
        return machine;
    }

    /** Another machine, with some keys changed: {{"axis.x.load.slide.gap_um", "25.0"}}. */
    Machine edit(std::initializer_list<std::pair<const char *, const char *>> changes) const
    {
        std::vector<const char *> keys, values;
        for (const auto &[key, value] : changes) {
            keys.push_back(key);
            values.push_back(value);
        }
        Machine machine;
        check(lm_machine_edit(get(), keys.data(), values.data(), keys.size(), machine.put()));
        return machine;
    }

    double number(const std::string &key) const
    {
        double number = 0.0;
        check(lm_machine_number(get(), key.c_str(), &number));
        return number;
    }

    std::string toml() const
    {
        Text text;
        check(lm_machine_toml(get(), text.put()));
        return text.string();
    }
};

/** A compensator of one's own: a class that is made from `const LmAxisFacts &`, can be copied, and has
 * `LmCorrection step(const LmTick &)`. What it throws makes the compensator fail. */
template <typename T> LmCompensator compensator(const char *name, bool load_scale = false)
{
    LmCompensator own{};
    own.size = sizeof own;
    own.name = name;
    own.create = [](void *, const LmAxisFacts *facts, double) noexcept -> void * {
        try {
            return new T(*facts);
        } catch (...) {
            return nullptr;
        }
    };
    own.copy = [](const void *state) noexcept -> void * {
        try {
            return new T(*static_cast<const T *>(state));
        } catch (...) {
            return nullptr;
        }
    };
    own.destroy = [](void *state) noexcept { delete static_cast<T *>(state); };
    own.step = [](void *state, const LmTick *tick, LmCorrection *correction) noexcept {
        try {
            *correction = static_cast<T *>(state)->step(*tick);
        } catch (...) {
            /* no number: the library ends the run */
            correction->position = std::numeric_limits<double>::quiet_NaN();
        }
    };
    own.load_scale = load_scale;
    return own;
}

/** What came of a run; texts of blocks and results live as long as it. */
class Run : public Handle<LmRun, lm_run_free> {
  public:
    LmRunInfo info() const
    {
        LmRunInfo info;
        check(lm_run_info(get(), &info));
        return info;
    }

    LmMethodResult result(std::size_t index) const
    {
        LmMethodResult result;
        check(lm_run_result(get(), index, &result));
        return result;
    }

    std::vector<LmMethodResult> results() const
    {
        std::vector<LmMethodResult> all;
        for (std::size_t index = 0, count = info().results; index < count; index++)
            all.push_back(result(index));
        return all;
    }

    /** Blocks of a method with the largest errors, worst first. */
    std::vector<LmBlock> worst_blocks(std::size_t method = 0) const
    {
        std::vector<LmBlock> blocks(result(method).worst_blocks);
        for (std::size_t index = 0; index < blocks.size(); index++)
            check(lm_run_worst_block(get(), method, index, &blocks[index]));
        return blocks;
    }

    /** Any figure, by its place as a JSON pointer. */
    double number(const std::string &pointer) const
    {
        double number = 0.0;
        check(lm_run_number(get(), pointer.c_str(), &number));
        return number;
    }

    std::string json() const { return read(lm_run_json); }
    std::string text() const { return read(lm_run_text); }
    std::string page() const { return read(lm_run_page); }
    std::string learned() const { return read(lm_run_learned); }

  private:
    std::string read(LmStatus (*function)(const LmRun *, LmText **)) const
    {
        Text text;
        check(function(get(), text.put()));
        return text.string();
    }
};

/** A program on a machine. Callbacks answer whether to go on. */
class Simulation : public Handle<LmSimulation, lm_simulation_free> {
  public:
    Simulation(const Program &program, const Machine &machine)
    {
        check(lm_simulation_new(program.get(), machine.get(), put()));
    }

    Simulation &method(const std::string &name)
    {
        check(lm_simulation_method(get(), name.c_str()));
        return *this;
    }

    Simulation &compensator(const LmCompensator &own)
    {
        check(lm_simulation_compensator(get(), &own));
        return *this;
    }

    template <typename N, std::enable_if_t<std::is_arithmetic_v<N>, int> = 0>
    Simulation &set(const std::string &key, N number)
    {
        check(lm_simulation_set(get(), key.c_str(), static_cast<double>(number)));
        return *this;
    }

    Simulation &set(const std::string &key, const std::string &text)
    {
        return set(key, text.c_str());
    }

    Simulation &set(const std::string &key, const char *text)
    {
        check(lm_simulation_set_text(get(), key.c_str(), text));
        return *this;
    }

    Simulation &set_json(const std::string &key, const std::string &json)
    {
        check(lm_simulation_set_json(get(), key.c_str(), json.c_str()));
        return *this;
    }

    Simulation &keep_page()
    {
        check(lm_simulation_keep_page(get(), true));
        return *this;
    }

    Simulation &on_progress(std::function<bool(const LmProgress &)> told)
    {
        callbacks().progress = std::move(told);
        check(lm_simulation_on_progress(
            get(),
            [](void *user, const LmProgress *progress) noexcept {
                auto &callbacks = *static_cast<Callbacks *>(user);
                return callbacks.guarded([&] { return callbacks.progress(*progress); });
            },
            &callbacks()));
        return *this;
    }

    Simulation &
    on_contour(std::function<bool(std::size_t, const LmContourSample *, std::size_t)> told)
    {
        callbacks().contour = std::move(told);
        check(lm_simulation_on_contour(
            get(),
            [](void *user, std::size_t method, const LmContourSample *samples,
               std::size_t count) noexcept {
                auto &callbacks = *static_cast<Callbacks *>(user);
                return callbacks.guarded([&] { return callbacks.contour(method, samples, count); });
            },
            &callbacks()));
        return *this;
    }

    Simulation &on_blocks(std::function<bool(std::size_t, const LmBlock *, std::size_t)> told)
    {
        callbacks().blocks = std::move(told);
        check(lm_simulation_on_blocks(
            get(),
            [](void *user, std::size_t method, const LmBlock *blocks, std::size_t count) noexcept {
                auto &callbacks = *static_cast<Callbacks *>(user);
                return callbacks.guarded([&] { return callbacks.blocks(method, blocks, count); });
            },
            &callbacks()));
        return *this;
    }

    Simulation &on_plan(std::function<bool(const LmPlanSample *, std::size_t)> told)
    {
        callbacks().plan = std::move(told);
        check(lm_simulation_on_plan(
            get(),
            [](void *user, const LmPlanSample *samples, std::size_t count) noexcept {
                auto &callbacks = *static_cast<Callbacks *>(user);
                return callbacks.guarded([&] { return callbacks.plan(samples, count); });
            },
            &callbacks()));
        return *this;
    }

    Run run()
    {
        Run run;
        ended(lm_simulation_run(get(), run.put()));
        return run;
    }

    LmPlan plan()
    {
        LmPlan plan;
        ended(lm_simulation_plan(get(), &plan));
        return plan;
    }

    /** Ends the run that is going on; from any thread. */
    void cancel() const { check(lm_simulation_cancel(get())); }

  private:
    struct Callbacks {
        std::function<bool(const LmProgress &)> progress;
        std::function<bool(std::size_t, const LmContourSample *, std::size_t)> contour;
        std::function<bool(std::size_t, const LmBlock *, std::size_t)> blocks;
        std::function<bool(const LmPlanSample *, std::size_t)> plan;
        std::exception_ptr thrown;

        template <typename F> bool guarded(F callback) noexcept
        {
            try {
                return callback();
            } catch (...) {
                thrown = std::current_exception();
                return false;
            }
        }
    };

    void ended(LmStatus status)
    {
        if (auto thrown = std::exchange(callbacks().thrown, nullptr))
            std::rethrow_exception(thrown);
        check(status);
    }

    Callbacks &callbacks()
    {
        /* a simulation that was moved from has none, and no handle: what is called next says so */
        if (!callbacks_)
            callbacks_ = std::make_unique<Callbacks>();
        return *callbacks_;
    }

    /* where it is stays: the library has its address */
    std::unique_ptr<Callbacks> callbacks_ = std::make_unique<Callbacks>();
};

/** One axis alone. */
class Axis : public Handle<LmAxis, lm_axis_free> {
  public:
    Axis(const Machine &machine, const std::string &drive, const std::string &method = "none",
         double start = 0.0, bool differences = true)
    {
        check(lm_axis_new(machine.get(), drive.c_str(), method.c_str(), start, differences, put()));
    }

    Axis(const Machine &machine, const std::string &drive, const LmCompensator &own,
         double start = 0.0, bool differences = true)
    {
        check(lm_axis_with_compensator(machine.get(), drive.c_str(), &own, start, differences,
                                       put()));
    }

    LmAxisInfo info() const
    {
        LmAxisInfo info;
        check(lm_axis_info(get(), &info));
        return info;
    }

    /** A command cycle: `count` is the servo ticks in it. */
    void step(const LmSetpoint &setpoint, LmAxisSample *samples, std::size_t count)
    {
        check(lm_axis_step(get(), &setpoint, samples, count));
    }

    void setpoint(const LmSetpoint &setpoint) { check(lm_axis_setpoint(get(), &setpoint)); }

    LmAxisSample tick()
    {
        LmAxisSample sample;
        check(lm_axis_tick(get(), &sample));
        return sample;
    }
};

/** A setpoint with velocity and acceleration. */
inline LmSetpoint moving(double position, double velocity, double acceleration)
{
    LmSetpoint setpoint{};
    setpoint.position = position;
    setpoint.velocity = velocity;
    setpoint.acceleration = acceleration;
    setpoint.given = LM_SETPOINT_VELOCITY | LM_SETPOINT_ACCELERATION;
    return setpoint;
}

} // namespace lostmotion

#endif
