#pragma once

#include "backends/program.h"

namespace powdercal {

// A program in which every member differs from its default, but for the explicit packing.
inline Program SampleProgram() {
  Program program;
  program.experiment = "consolidation";
  program.parameters = {{"rolling_friction", 0.5}, {"cohesion_energy_density", 47500}};
  program.fidelity = Fidelity::standard;
  program.particles.sizes = {SizeDistribution::Kind::normal, 29e-6, 6e-6, 12.5e-6, 37.5e-6};
  program.particles.count = 1000;
  program.particles.seed = 18446744073709551615ULL;
  program.particles.contacts = {{7, 8, {1e-9, 2e-9, 3e-9}, {4e-15, 5e-15, 6e-15}},
                                {9, -2, {1.5e-9, 2.5e-9, 3.5e-9}, {7e-15, 8e-15, 9e-15}}};
  program.materials = {.density = 8220,
                       .young_modulus = 5e6,
                       .poisson_ratio = 0.3,
                       .particle_particle = {0.4, 0.3, 0.5, 47500, 1e-4},
                       .particle_wall = {0.41, 0.31, 0.51, 47501, 2e-4},
                       .linear = {12, 8, 1e-6, 2e-6}};
  program.law = {ContactLaw::Normal::linear,
                 true,
                 ContactLaw::Tangential::no_history,
                 ContactLaw::ShearUpdate::incremental,
                 ContactLaw::Cohesion::sjkr2,
                 ContactLaw::Rolling::epsd2,
                 false};
  program.domain = {{-1e-4, -2e-4, 0},
                    {3e-4, 2e-4, 1e-3},
                    {Boundary::outflow, Boundary::open, Boundary::periodic}};
  program.walls = {{"side", 0, -1e-4, false, true}, {"top", 1, 9e-4, false, true}};
  program.meshes = {{"blade",
                     {{0, 0, 1e-4}, {1e-4, 0, 1e-4}, {0, 2e-4, 3e-4}, {1e-4, 2e-4, 3e-4}},
                     {{0, 1, 2}, {1, 3, 2}}}};
  program.groups = {{"base", {1, 2, 5}}};
  program.gravity = {0.1, 0.2, -9.8};
  program.time_step = 2.5e-7;
  program.stages = {Insert{1e-5, 8e-4, {0, 0, -0.1}},
                    Settle{1e-3, 1e-4, 1e-3, 0.02},
                    Servo{"top", 900, 0.05, 0.03},
                    Hold{0.02, 0.1, 1e-4, 1e-3, 0.05},
                    Advance{"sweep",
                            0.04,
                            {{"blade", {0.025, 1e-3, 2e-3}, {1, 2, 3}, {1e-5, 2e-5, 3e-5}},
                             {"base", {0.01, 0.02, 0.03}, {4, 5, 6}, {4e-5, 5e-5, 6e-5}}},
                            100},
                    Deform{"shear",
                           0.05,
                           {{{EdgeControl::Kind::stress, 800},
                             {EdgeControl::Kind::strain_rate, -0.5},
                             {EdgeControl::Kind::stress, 900}}},
                           40,
                           50,
                           2.5}};
  return program;
}

}  // namespace powdercal
