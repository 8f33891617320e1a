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
  program.materials = {.density = 8220,
                       .young_modulus = 5e6,
                       .poisson_ratio = 0.3,
                       .particle_particle = {0.4, 0.3, 0.5, 47500, 1e-4},
                       .particle_wall = {0.41, 0.31, 0.51, 47501, 2e-4}};
  program.law = {ContactLaw::Normal::linear,
                 true,
                 ContactLaw::Tangential::no_history,
                 ContactLaw::ShearUpdate::incremental,
                 ContactLaw::Cohesion::sjkr2,
                 ContactLaw::Rolling::epsd2,
                 false};
  program.domain = {{-1e-4, -2e-4, 0},
                    {3e-4, 2e-4, 1e-3},
                    {Boundary::periodic, Boundary::open, Boundary::periodic}};
  program.walls = {{"floor", 0, true}, {"top", 9e-4, false}};
  program.gravity = {0.1, 0.2, -9.8};
  program.time_step = 2.5e-7;
  program.stages = {Insert{1e-5, 8e-4, {0, 0, -0.1}}, Settle{1e-3, 1e-4, 1e-3, 0.02},
                    Servo{"top", 900, 0.05, 0.03}, Hold{0.02, 0.1, 1e-4, 1e-3, 0.05}};
  return program;
}

}  // namespace powdercal
