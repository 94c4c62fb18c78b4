/*
 * The whole chain on a machine that is made in code: checked like a file. As own_machine.rs.
 */

#include <cstdio>
#include <lostmotion.hpp>
#include <string>

/* A plotter of two axes: that of the X of an embedded mill, with limits of its own. */
static lostmotion::Machine plotter()
{
    std::string toml = "name = \"plotter\"\n[kinematics]\nkind = \"cartesian\"\n";
    for (const std::string axis : {"axis.x", "axis.y"})
        toml += "[" + axis + ".limits]\n" +
                "min_mm = -200.0\nmax_mm = 200.0\nvelocity_mm_s = 150.0\n"
                "acceleration_mm_s2 = 1500.0\njerk_mm_s3 = 30000.0\n"
                "[" + axis + ".transmission.linear]\nlead_mm = 16.0\n"
                "[" + axis + ".motor]\n"
                "resistance_ohm = 0.42\ninductance_h = 0.0045\npoles = 10\n"
                "inertia_kgm2 = 0.00189\ntorque_constant_nm_per_a = 1.08\n"
                "rated_torque_nm = 11.0\nviscous_nm_s_per_rad = 0.002\ncoulomb_nm = 0.15\n"
                "[" + axis + ".load.slide]\n"
                "screw_inertia_kgm2 = 0.00198\nmass_kg = 300.0\nviscous_n_s_per_m = 500.0\n"
                "coulomb_n = 300.0\nstiffness_n_per_um = 238.0\ndamping_n_s_per_mm = 22.0\n"
                "gap_um = 5.0\nscale_um = 0.1\n"
                "[" + axis + ".drive]\n"
                "current_gain_v_per_a = 11.31\ncurrent_time_s = 0.01071\n"
                "velocity_gain_a_s_per_rad = 2.702\nvelocity_time_s = 0.007943\n"
                "position_gain_per_s = 62.8\nvelocity_feedforward = 1.0\n"
                "acceleration_feedforward = 1.0\ncurrent_limit_a = 28.0\nbus_voltage_v = 560.0\n"
                "encoder_counts_per_rev = 1048576\nvoltage_delay_periods = 1\n";
    return lostmotion::Machine::from_toml("plotter", toml);
}

static void tell(const char *name, const lostmotion::Program &program,
                 const lostmotion::Machine &machine)
{
    const auto run = lostmotion::Simulation(program, machine).run();
    const auto first = run.result(0);
    std::printf("%s: %s leaves %.1f um of backlash at most\n", name, first.method,
                first.backlash.max);
}

int main()
{
    using namespace lostmotion;
    const auto program =
        Program::from_text("circle.ngc", "G21 G90 G17 G94\nG0 X30 Y0\nG3 I-30 P2 F2400\nM2\n");
    const auto tight = plotter();
    const auto wide =
        tight.edit({{"name", "\"worn plotter\""}, {"axis.x.load.slide.gap_um", "40.0"}});
    tell("plotter", program, tight);
    tell("worn plotter", program, wide);

    try {
        wide.edit({{"axis.y.drive.position_gain_per_s", "-1.0"}});
    } catch (const Error &error) {
        for (const auto &found : error.findings)
            std::printf("%s: %s\n", found.key.c_str(), found.message.c_str());
    }
}
