#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "backends/program.h"

namespace powdercal::embedded {

// What the hot loops share with the rest of the engine. Particles are rows, so that one load brings
// a particle's position and another its velocity; contacts are columns, read in order.

/// Instruction sets that the kernels were compiled for.
enum class Isa { portable, avx2, avx512 };
std::span<const std::string> IsaNames();
/// Whether this processor has it.
bool Has(Isa isa);
Isa BestIsa();

/// Contact lists are padded to a multiple of this with inert entries.
inline constexpr int kPadding = 8;

/// A particle is a row of doubles: x y z r, vx vy vz 0, wx wy wz 0, fx fy fz 0, tx ty tz 0. Rows
/// are aligned to 32 bytes. Lists name particles by the offset of their row from the first one.
inline constexpr int kRow = 20;
inline constexpr int kVelocity = 4;
inline constexpr int kSpin = 8;
inline constexpr int kForce = 12;
inline constexpr int kTorque = 16;
using Offset = std::uint32_t;
inline constexpr Offset OffsetOf(std::int32_t particle) {
  return static_cast<Offset>(particle) * static_cast<Offset>(kRow);
}
inline constexpr std::int32_t ParticleOf(Offset offset) {
  return static_cast<std::int32_t>(offset / static_cast<Offset>(kRow));
}

/// How the nearest image of a neighbour is found. Lees–Edwards: the image one cell above is
/// displaced by `shear_offset` along x and faster by `shear_speed`. In a cell that changes its size
/// images move at `speed` (dL/dt).
struct Images {
  double length[3] = {1, 1, 1};   ///< [m]
  double inverse[3] = {0, 0, 0};  ///< [1/m] 0 along axes that are not periodic
  double speed[3] = {0, 0, 0};    ///< [m/s]
  double shear_offset = 0;        ///< [m]
  double shear_speed = 0;         ///< [m/s]
};

/// The contact law's constants for one kind of partners.
struct LawConstants {
  double normal = 0;          ///< Hertz: 4/3 E* [Pa]; linear: k_n [N/m]
  double tangential = 0;      ///< Hertz: 8 G* [Pa]; linear: k_t [N/m]
  double normal_damping = 0;  ///< Hertz: 2 √(5/6) beta √(2 E*) [Pa^0.5]; linear: gamma_n [kg/s]
  double tangential_damping = 0;   ///< Hertz: 2 √(5/6) beta √(8 G*) [Pa^0.5]; linear: gamma_t
  double friction = 0;             ///< [-]
  double rolling = 0;              ///< [-]
  double cohesion_slope = 0;       ///< [Pa] pull per R* · delta: 4 pi k, at walls 2 pi k
  double cohesion_constant = 0;    ///< [N/m] pull per R*: 4 pi gamma
  bool tangential_reduce = false;  ///< the pull counts where friction and epsd2 have their limits
  /// Least normal force before cohesion [N]: 0 with limit_force, else −infinity.
  double least_normal = -std::numeric_limits<double>::infinity();
  double without_torsion = 0;  ///< 1: rolling friction leaves spin about the normal alone
  double time_step = 0;        ///< [s]
};

/// Contacts in columns of `size` (a multiple of kPadding). For walls and surfaces j is not used.
struct ContactColumns {
  std::int32_t size = 0;
  const Offset* i = nullptr;
  const Offset* j = nullptr;
  const double* radius_sum = nullptr;        ///< [m] ri + rj; at walls r; negative: inert
  const double* effective_radius = nullptr;  ///< [m] R*
  const double* effective_mass = nullptr;    ///< [kg] m*
  double* shear[3] = {};                     ///< `history` only, as ContactHistory::shear
  double* rolling[3] = {};                   ///< `epsd2` only, as ContactHistory::rolling
  double* force[3] = {};                     ///< [N] on i, written unless null
};

/// A plane seen by the kernels: the particles are where normal · x > offset.
struct PlaneState {
  double normal[3] = {};    ///< unit vector towards the particles
  double offset = 0;        ///< [m]
  double velocity[3] = {};  ///< [m/s]
};

/// Contacts with surfaces, found before the kernel runs.
struct SurfaceColumns {
  const double* normal[3] = {};      ///< unit vector from the surface to the centre
  const double* distance = nullptr;  ///< [m] centre to surface
  const double* velocity[3] = {};    ///< [m/s] of the surface at the contact
};

/// What moves particles beside contact forces.
struct Drive {
  double gravity[3] = {};  ///< [m/s2]
  double time_step = 0;    ///< [s]
  double rate[3] = {};     ///< [1/s] strain rates of the cell
  double shear_rate = 0;   ///< [1/s] dv_x/dz
  double centre[3] = {};   ///< [m] where the affine velocity is zero
};

enum class TangentialKernel { no_history, displacement, incremental };

/// Pairs: adds the forces and torques of all contacts to the particles' loads.
using PairKernel = void (*)(const LawConstants&, const Images&, double* rows,
                            const ContactColumns&);
/// A plane's contacts; adds the force on the plane to force[3].
using PlaneKernel = void (*)(const LawConstants&, const PlaneState&, double* rows,
                             const ContactColumns&, double* force);
using SurfaceKernel = void (*)(const LawConstants&, const SurfaceColumns&, double* rows,
                               const ContactColumns&, double* force);
/// Sets accept[n] to 1 where the surfaces of pair n are closer than `gap` [m], else 0; sizes are
/// multiples of kPadding.
using PruneKernel = void (*)(const Images&, const double* rows, const Offset* i, const Offset* j,
                             std::int32_t size, double gap, std::uint8_t* accept);

/// Velocity Verlet over particles [begin, end): kick: half a step of velocity from the loads,
/// drift: a step of position. `inverse_mass` and `inverse_inertia` are 0 for particles that do not
/// answer to forces (nor to gravity).
struct Integration {
  const double* inverse_mass = nullptr;
  const double* inverse_inertia = nullptr;
  bool finish_step = false;  ///< kick with the loads of the step that ends
  bool begin_step = false;   ///< kick again and drift, then clear the loads
};
/// Returns the largest square of velocity, less the affine one, of the particles [m2/s2].
using IntegrateKernel = double (*)(const Drive&, double* rows, const Integration&,
                                   std::int32_t begin, std::int32_t end);

struct Kernels {
  Isa isa = Isa::portable;
  int lanes = 0;
  PairKernel pairs = nullptr;
  PlaneKernel plane = nullptr;
  SurfaceKernel surface = nullptr;
  PruneKernel prune = nullptr;
  IntegrateKernel integrate = nullptr;
};

/// The loops for a contact law. Requires Has(isa).
Kernels KernelsFor(Isa isa, const ContactLaw& law);

/// One table for each instruction set: kernels_portable.cc, kernels_avx2.cc, kernels_avx512.cc.
/// Indices: normal law, tangential kernel, rolling law.
struct KernelTable {
  int lanes;
  PairKernel pairs[2][3][3];
  PlaneKernel plane[2][3][3];
  SurfaceKernel surface[2][3][3];
  PruneKernel prune;
  IntegrateKernel integrate;
};
extern const KernelTable kPortableKernels;
extern const KernelTable kAvx2Kernels;
extern const KernelTable kAvx512Kernels;

}  // namespace powdercal::embedded
