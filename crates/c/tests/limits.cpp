/* What callbacks throw comes out of the run; moved objects free once. */

#include <lostmotion.hpp>

#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

int main()
{
    using namespace lostmotion;
    int faults = 0;
    {
        auto program = Program::from_text("p.ngc", "G21 G90\nG1 X40 F3000\nX0\nM2\n");
        auto moved = std::move(program);
        const auto machine = Machine::preset("vmc3");
        Simulation simulation(moved, machine);
        simulation.on_progress([](const LmProgress &) -> bool { throw std::logic_error("mine"); });
        try {
            simulation.run();
            faults++;
        } catch (const std::logic_error &error) {
            faults += std::string(error.what()) != "mine";
        }
        try {
            Simulation(program, machine);
            faults++;
        } catch (const Error &error) {
            faults += error.status != LM_STATUS_NULL;
        }
        try {
            const auto wrong = Program::from_text("w.ngc", "G21\nG1 Z-\n");
            Simulation(wrong, machine).run();
            faults++;
        } catch (const Error &error) {
            faults += error.findings.empty() || error.line != 2 || error.findings[0].line != 2;
        }
        const auto operations = moved.operations();
        faults += operations.size() < 4 || operations.back().line != 4;
        faults += moved.format("{\"case\": \"lower\"}").find("g1 x40") == std::string::npos;
        faults += moved.resolved().find("X40") == std::string::npos;
        faults += Program::from_text("w.ngc", "G21\nG1 Z-\n").lint().at(0).line != 2;
        try {
            (void)Program::from_text("w.ngc", "G21\nG1 Z-\n").operations();
            faults++;
        } catch (const Error &error) {
            faults += error.status != LM_STATUS_PROGRAM || error.line != 2;
        }
        std::size_t samples = 0, blocks = 0;
        Simulation again(moved, machine);
        Simulation kept = std::move(again);
        kept.on_contour([&](std::size_t, const LmContourSample *, std::size_t count) {
            samples += count;
            return true;
        });
        kept.on_blocks([&](std::size_t, const LmBlock *, std::size_t count) {
            blocks += count;
            return true;
        });
        const auto run = kept.keep_page().run();
        faults += samples < 4000 || blocks != 2 || run.page().size() < 10000;
        /* what was moved from says so, whatever is called */
        const std::vector<std::function<void()>> calls = {
            [&] { again.run(); },
            [&] { again.plan(); },
            [&] { again.cancel(); },
            [&] { again.set("threads", 0); },
            [&] { again.on_progress([](const LmProgress &) { return true; }); },
            [&] { again.on_blocks([](std::size_t, const LmBlock *, std::size_t) { return true; }); },
        };
        for (const auto &call : calls) {
            try {
                call();
                faults++;
            } catch (const Error &error) {
                faults += error.status != LM_STATUS_NULL;
            }
        }
        /* what is assigned to is freed with its callbacks, and the other is empty */
        Simulation other(moved, machine);
        other.on_progress([](const LmProgress &) { return true; });
        kept = std::move(other);
        faults += other.get() != nullptr;
        kept.set("threads", 0).set("tolerance_um", 20).set("quality", std::string("fast")).run();
        faults += run.json().find("\"schema\"") == std::string::npos;
    }
    faults += lm_handles() != 0;
    std::printf("c++: %d faults\n", faults);
    return faults;
}
