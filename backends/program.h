#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace powdercal {

// A Program says what is to be simulated, in terms that every DEM code shares, and nothing about
// how a particular one does it. SI units throughout; z points up.

using Vector3 = std::array<double, 3>;

/// How large a simulation is: quick for exploring, standard for results, paper for the size that
/// the seed publication used. What each means is the experiment's choice.
enum class Fidelity { quick, standard, paper };
std::span<const std::string> FidelityNames();
const std::string& ToString(Fidelity fidelity);

/// Particle diameters by number, truncated to [min, max].
struct SizeDistribution {
  enum class Kind { monodisperse, normal, lognormal };
  Kind kind = Kind::monodisperse;
  double mean = 0;  ///< [m] of the untruncated distribution; the diameter if monodisperse
  double standard_deviation = 0;  ///< [m] of the untruncated distribution (lognormal: of d itself)
  double min = 0;                 ///< [m] without meaning if monodisperse, as is max
  double max = 0;                 ///< [m]

  /// "" if the members make sense together, else what is wrong.
  std::string ExplainInvalid() const;
  /// Diameter at the cumulative number fraction p in [0, 1]; Quantile(0) is the smallest diameter.
  double Quantile(double p) const;
  /// Number mean of d^power after truncation [m^power]; power 1, 2 or 3.
  double Moment(int power) const;
};
std::span<const std::string> SizeDistributionNames();

/// Parameters of contact between two kinds of bodies.
struct ContactParameters {
  double restitution = 0;              ///< [-] in (0, 1]
  double friction = 0;                 ///< [-] Coulomb
  double rolling_friction = 0;         ///< [-]
  double cohesion_energy_density = 0;  ///< [J/m3] k of SJKR2
  double surface_energy = 0;           ///< [J/m2] gamma of DMT
};

/// Constants of the linear law, F_n = k_n delta − gamma_n v_n, F_t = −k_t xi − gamma_t v_t: the
/// same for every pair, whatever its sizes. They stand in place of E, nu and the restitution, which
/// the linear law does not look at.
struct LinearStiffness {
  double normal = 0;              ///< [N/m] k_n
  double tangential = 0;          ///< [N/m] k_t
  double normal_damping = 0;      ///< [kg/s] gamma_n
  double tangential_damping = 0;  ///< [kg/s] gamma_t
};

/// Elastic and contact parameters of the powder and of the walls (walls share E and nu).
struct Materials {
  double density = 0;        ///< [kg/m3] of the solid
  double young_modulus = 0;  ///< [Pa] of the simulated particles
  double poisson_ratio = 0;  ///< [-]
  ContactParameters particle_particle;
  ContactParameters particle_wall;
  LinearStiffness linear;  ///< of the linear normal law, at particles and walls alike
};

/// The canonical contact law; docs/physics.md has the formulas of each name.
struct ContactLaw {
  enum class Normal { hertz, linear };
  enum class Tangential { history, no_history };
  enum class ShearUpdate { displacement, incremental };
  enum class Cohesion { none, sjkr2, dmt };
  enum class Rolling { none, cdt, epsd2 };

  Normal normal = Normal::hertz;
  bool limit_force = false;  ///< clip the normal force at zero before cohesion is added
  Tangential tangential = Tangential::history;
  ShearUpdate shear_update = ShearUpdate::displacement;
  Cohesion cohesion = Cohesion::none;
  Rolling rolling = Rolling::none;
  bool torsion = true;  ///< rolling friction resists spin about the line of centres as well
  /// Sliding friction and `epsd2` are limited by the net normal force, with the pull of cohesion in
  /// it, instead of the force without. Written into a program only where it is on, so that programs
  /// from before it keep their hashes.
  bool tangential_reduce = false;

  /// "hertz + history (displacement) + sjkr2 + epsd2 with torsion, limit_force off".
  std::string ToString() const;
};
std::span<const std::string> NormalLawNames();
std::span<const std::string> TangentialLawNames();
std::span<const std::string> ShearUpdateNames();
std::span<const std::string> CohesionNames();
std::span<const std::string> RollingNames();

/// One sphere of a packing.
struct Sphere {
  std::int64_t id = 0;  ///< 1, 2, …; kept through the whole simulation
  double radius = 0;    ///< [m]
  Vector3 position{};   ///< [m]
  Vector3 velocity{};   ///< [m/s]
  Vector3 spin{};       ///< [rad/s]
};
using Packing = std::vector<Sphere>;

/// What a contact remembers: all that a packing does not say of a bed under load. Vectors are those
/// of the contact as sphere i sees it.
struct ContactHistory {
  std::int64_t i = 0;  ///< id
  std::int64_t j = 0;  ///< id of the other sphere; −1 − w for the plane `Program::walls[w]`
  Vector3 shear{};     ///< [m] xi of `displacement`; [N] elastic tangential force of `incremental`
  Vector3 rolling{};   ///< [N m] torque of the rolling spring of `epsd2`
};

/// The particles: drawn from a distribution with a seed, or an explicit packing.
struct Particles {
  SizeDistribution sizes;
  int count = 0;
  std::uint64_t seed = 0;
  std::optional<Packing> packing;        ///< takes precedence over count and seed
  std::vector<ContactHistory> contacts;  ///< of an explicit packing; empty: none remembers anything
};

/// What happens at a pair of opposite sides of the domain. open: no particle may leave, one that
/// does is lost, and the run has failed. outflow: particles may leave; they are removed and
/// counted.
enum class Boundary { periodic, open, outflow };

struct Domain {
  Vector3 lower{};  ///< [m]
  Vector3 upper{};  ///< [m]
  std::array<Boundary, 3> boundaries{Boundary::periodic, Boundary::periodic, Boundary::open};

  Vector3 Lengths() const {
    return {upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]};
  }
  /// Area of the base, x by y [m2].
  double BaseArea() const { return (upper[0] - lower[0]) * (upper[1] - lower[1]); }
};

/// A flat wall perpendicular to one axis, infinite along the others.
struct PlaneWall {
  std::string name;
  int axis = 2;                 ///< 0, 1, 2: x, y, z
  double position = 0;          ///< [m] along the axis
  bool facing_positive = true;  ///< the particles are on the side of larger coordinates
  bool frictionless = false;    ///< contacts carry the normal force alone: no friction, cohesion,
                                ///< or rolling friction
};

/// A surface of triangles, such as a blade or a ridged plate; it acts on both of its sides. Edges
/// and corners that triangles share are told from equal coordinates.
struct Mesh {
  std::string name;
  std::vector<Vector3> vertices;              ///< [m]
  std::vector<std::array<int, 3>> triangles;  ///< indices of vertices
};

/// Particles that move as one rigid piece and never turn, such as the rough floor of a shear cell.
/// Contacts within a group carry no force.
struct GluedGroup {
  std::string name;
  std::vector<std::int64_t> ids;  ///< of the explicit packing
};

/// Places `particles` at random, without overlap, in a slab of the domain (see insertion.h).
struct Insert {
  double bottom = 0;   ///< [m] z range of sphere centres is [bottom + r, top − r]
  double top = 0;      ///< [m]
  Vector3 velocity{};  ///< [m/s] common to all spheres
};

/// Runs under gravity until the bed is at rest: the kinetic energy per particle is below
/// `kinetic_energy_ratio` · m g d, checked every `check_interval` from `min_duration` on; ends
/// without failure at `max_duration`, since what counts is the state after loading.
struct Settle {
  double kinetic_energy_ratio = 0;  ///< [-]
  double check_interval = 0;        ///< [s]
  double min_duration = 0;          ///< [s]
  double max_duration = 0;          ///< [s]
};

/// Places the wall (a plane, a mesh or a glued group) just above the highest particle and loads the
/// bed with it to a normal stress along z, downward, over the area of the domain's base; it then
/// follows the bed and keeps the stress, also in the stages after this one. The gain of the
/// controller is the backend's matter: it must be stable for the contact stiffness at hand. Ends
/// when 90 % of the stress is reached, or at `max_duration`; what follows then finds that the
/// stress is missed.
///
/// Where the wall bears an earlier stage's servo already, it stays where it is and changes to the
/// new stress; the stage ends when it is within 10 % of it. A program has one such wall.
struct Servo {
  std::string wall;
  double stress = 0;        ///< [Pa] compressive, positive
  double max_velocity = 0;  ///< [m/s]
  double max_duration = 0;  ///< [s]
};

/// Keeps the servo's stress until the bed is quasi-static: over one window the mean stress is
/// within `stress_tolerance` of the target, the wall's mean strain rate |dh/dt|/h is below
/// `strain_rate`, and the kinetic energy is below `kinetic_energy_ratio` times the elastic contact
/// energy (estimated as stress · volume / kappa where a backend does not know it). Past
/// `max_duration` the outcome is `not_quasi_static`.
struct Hold {
  double stress_tolerance = 0;      ///< [-]
  double strain_rate = 0;           ///< [1/s]
  double kinetic_energy_ratio = 0;  ///< [-]
  double window = 0;                ///< [s]
  double max_duration = 0;          ///< [s]
};

/// Prescribed rigid motion of a plane, a mesh or a glued group. A plane moves along its own axis;
/// along the others its surface slides past the particles. Only meshes turn.
struct Motion {
  std::string body;
  Vector3 velocity{};  ///< [m/s]
  Vector3 spin{};      ///< [rad/s] about `centre`, which moves along
  Vector3 centre{};    ///< [m] at the beginning of the stage
};

/// Runs for a time, with bodies in prescribed motion; those not named rest, servos go on. A motion
/// ends with its stage.
struct Advance {
  std::string name = "advance";  ///< of the moment at its end; distinct within a program
  double duration = 0;           ///< [s] rounded to whole steps
  std::vector<Motion> motions;
  /// Packings on the way: a moment named `name` every so many steps. 0: only the one at the end.
  int packing_every = 0;
};

/// What one edge of a periodic cell does.
struct EdgeControl {
  enum class Kind { strain_rate, stress };
  Kind kind = Kind::strain_rate;
  double value =
      0;  ///< [1/s] of the edge's length, positive: it grows; or [Pa] compressive, positive
};
std::span<const std::string> EdgeControlNames();

/// Deforms a cell that is periodic in x, y and z: each edge at a rate or to a stress, and
/// Lees–Edwards shear, x displaced along z (Lees & Edwards 1972). Affine velocities are given to
/// the particles with the deformation, so that no boundary drives them. A stress-controlled edge
/// follows (dL/dt)/L = gain · rate · (s − s0)/s0, with s the filtered contact and kinetic stress
/// (weight 0.3, every 20 steps), at most 6 · rate; rate is `shear_rate`, or `relaxation_rate`
/// without shear.
struct Deform {
  std::string name = "deform";
  double duration = 0;  ///< [s]
  std::array<EdgeControl, 3> edges;
  double shear_rate = 0;       ///< [1/s] dv_x/dz
  double relaxation_rate = 0;  ///< [1/s] sets the pace of stress control where nothing is sheared
  double gain = 3;             ///< [-]
};

/// Remembers the whole state under a name: particles, contact springs, bodies, servo, cell. Takes
/// no time and leaves no moment.
struct Save {
  std::string name = "state";  ///< distinct within a program
};

/// Goes back to a remembered state, any number of times. The clock does not go back: times in the
/// trace keep growing. Leaves no moment.
struct Restore {
  std::string name = "state";
};

/// Takes a plane or a mesh out of the simulation, such as a gate that is opened: nothing touches it
/// any more. Not a servo's wall. Leaves no moment.
struct Remove {
  std::string body;
};

using Stage = std::variant<Insert, Settle, Servo, Hold, Advance, Deform, Save, Restore, Remove>;
/// "insert", "settle", "servo", "hold", "advance", "deform", "save", "restore", "remove".
const std::string& StageName(const Stage& stage);
/// Name of the trace's moment at the end of the stage: StageName(), but the stage's own `name` of
/// Advance and Deform.
const std::string& MomentName(const Stage& stage);

/// What to simulate. The trace holds a packing at the end of each stage but Insert, Save, Restore
/// and Remove.
struct Program {
  std::string experiment;                    ///< who planned it, e.g. "consolidation"
  std::map<std::string, double> parameters;  ///< the study's free parameters by canonical name, SI
  Fidelity fidelity = Fidelity::quick;
  Particles particles;
  Materials materials;
  ContactLaw law;
  Domain domain;
  std::vector<PlaneWall> walls;
  std::vector<Mesh> meshes;
  std::vector<GluedGroup> groups;
  Vector3 gravity{0, 0, -9.81};  ///< [m/s2]
  double time_step = 0;          ///< [s]
  std::vector<Stage> stages;
  /// [m] z range, well inside the bed: stress and solid fraction in it are recorded (Trace::slab).
  /// Empty: nothing is. For domains that are not periodic along z; a periodic cell has Trace::cell.
  std::optional<std::array<double, 2>> stress_slab;

  /// Canonical serialisation: sorted keys, every member, numbers with as many digits as it takes to
  /// read back the same double. A sphere of an explicit packing is the array [id, radius, x, y, z,
  /// vx, vy, vz, wx, wy, wz]. Requires finite numbers.
  nlohmann::json ToJson() const;
  /// The program that ToJson() wrote. Throws InputError where a member is missing, unknown or of
  /// the wrong kind.
  static Program FromJson(const nlohmann::json& json);
  /// SHA-256 of the canonical serialisation: equal programs, equal hashes.
  std::string Hash() const;
};

/// Rayleigh time of a sphere, pi·R·sqrt(rho/G)/(0.1631·nu + 0.8766) [s]: the time a surface wave
/// takes around half of it, the natural limit of the time step (Thornton & Randall 1988).
double RayleighTime(double radius, double density, double young_modulus, double poisson_ratio);

}  // namespace powdercal
