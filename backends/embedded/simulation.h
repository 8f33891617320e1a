#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "backends/embedded/bodies.h"
#include "backends/embedded/kernels.h"
#include "backends/embedded/mesh_contacts.h"
#include "backends/embedded/neighbours.h"
#include "backends/embedded/particle_store.h"
#include "backends/embedded/team.h"
#include "backends/program.h"
#include "backends/trace.h"

namespace powdercal::embedded {

struct Settings {
  Isa isa = Isa::portable;
  int threads = 1;
};

/// Energies and overlaps of the moment.
struct Survey {
  double kinetic_energy = 0;  ///< [J] of translation and spin
  double elastic_energy = 0;  ///< [J] in normal springs (Hertz: 2/5 F delta, linear: F delta/2)
  double max_overlap = 0;     ///< [-] largest delta/R*
  std::int64_t contacts = 0;  ///< touching pairs, and particles touching a plane or a mesh
  double top = 0;             ///< [m] highest point of any particle
};

/// Program::stress_slab at one moment; see SlabSeries.
struct SlabState {
  double solid_fraction = 0;        ///< [-]
  std::array<Vector3, 3> stress{};  ///< [Pa]
};

/// What a periodic cell's edges are told to do; see Deform.
struct CellDrive {
  std::array<EdgeControl, 3> edges;
  double shear_rate = 0;  ///< [1/s]
  double pace = 0;        ///< [1/s] rate of the stress control
  double gain = 0;

  /// See state_stream.h.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    for (auto& edge : self.edges) stream(edge.kind, edge.value);
    stream(self.shear_rate, self.pace, self.gain);
  }
};

/// A DEM simulation in progress: particles, contacts, walls, one time step after another. Velocity
/// Verlet, as LIGGGHTS' `nve/sphere`: forces see the velocities of half a step before.
///
/// A copy is a saved state. Copies share their threads: one may run at a time.
class Simulation {
 public:
  /// Takes geometry, law and time step from the program, particles from the packing. Throws
  /// InputError where the program cannot be run; see ExplainUnsupported().
  Simulation(const Program& program, const Packing& packing, const Settings& settings);

  /// Runs `count` steps. `interrupted` is asked every few steps, some milliseconds apart at most;
  /// when it says so, the run ends early and Run() returns false.
  bool Run(std::int64_t count, const std::function<bool()>& interrupted);

  /// Becomes the copy that was made of it earlier, and goes on as it would have done; only steps()
  /// and time() keep growing.
  void GoBackTo(const Simulation& saved);

  /// All that there is to go on with, as bytes: those of this kind of machine and this version of
  /// the engine. Instruction set and threads are not part of it. Requires that there is no
  /// failure().
  std::string SaveState() const;
  /// Becomes the simulation that gave these bytes, and goes on as it would have done, to the last
  /// bit. This one must have been made from the same program, with any packing, also an empty one.
  /// Throws InputError for bytes that are damaged, of another version, or of another program.
  void LoadState(std::string_view bytes);

  double time() const { return static_cast<double>(steps()) * program_.time_step; }
  std::int64_t steps() const { return steps_ + undone_steps_; }
  const ParticleStore& particles() const { return particles_; }
  int leavers() const { return leavers_; }
  /// Particles outside the domain along open axes, or with coordinates that are not numbers.
  int CountLost() const;

  Packing CurrentPacking() const;
  std::vector<ContactHistory> CurrentContacts() const;
  Survey MakeSurvey() const;
  /// The cell as it is now, with the stress of this moment.
  CellState Cell() const;
  /// Requires a program with a slab, and measured_slab() or the end of a Run().
  SlabState MeasureSlab() const;

  std::vector<PlaneBody>& planes() { return planes_; }
  std::vector<GroupBody>& groups() { return groups_; }
  std::vector<MeshBody>& meshes() { return meshes_; }
  const std::vector<PlaneBody>& planes() const { return planes_; }
  const std::vector<GroupBody>& groups() const { return groups_; }
  const std::vector<MeshBody>& meshes() const { return meshes_; }
  /// A body by its name; null if there is none.
  Body* FindBody(const std::string& name);
  /// Why the simulation cannot go on; set when Run() returns false without being interrupted.
  const std::optional<Outcome>& failure() const { return failure_; }
  /// Starts or stops deforming the cell. A drive that follows another at once takes over its filter
  /// of the stress.
  void SetCellDrive(const std::optional<CellDrive>& drive);
  /// Takes a plane or a mesh away. Its last force has its share in the next half step still.
  void Remove(Body& body);
  /// To be called when bodies were moved by hand: lists are rebuilt before the next step.
  void BodiesMoved() { lists_stale_ = true; }
  /// After each step with the forces of that step; for recorders.
  std::function<void()> after_step;
  /// Whether stress() is that of this step: while a cell is driven, every 20 steps.
  bool measured_cell() const { return cell_drive_.has_value() && Measures(); }
  /// Whether the forces of this step allow for MeasureSlab(): every 20 steps.
  bool measured_slab() const { return program_.stress_slab.has_value() && Measures(); }
  const std::array<Vector3, 3>& stress() const { return stress_; }  ///< [Pa] as in CellState
  double shear_strain() const { return shear_strain_; }  ///< [-] of the state, since the start
  const Box& box() const { return box_; }

  /// Counts since the start, for tuning and for the curious.
  struct Counters {
    std::int64_t rebuilds = 0;
    std::int64_t prunes = 0;
    std::int64_t pairs = 0;  ///< of the last inner list
    std::int64_t outer = 0;  ///< of the last outer list
    double inner_skin = 0;   ///< [m]
    double outer_skin = 0;   ///< [m]
  };
  Counters counters() const;

 private:
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream);
  void AddBodies();
  void MoveGroups();
  void Start();
  void RestoreContacts();
  void RefreshLists();
  void Rebuild();
  void ChooseSkins();
  bool CellTooSmall(double skin);
  void Pass(bool forces, bool finish, bool begin, bool record);
  void FinishForces(std::size_t slab, bool record);
  void Integrate(std::size_t slab, bool finish, bool begin);
  void AfterForces();
  void Move();
  bool Measures() const;
  void DeformCell();
  void ControlCell();
  Vector3 ControlledRates() const;
  void SetRates(const Vector3& rate, double shear_rate);
  std::vector<std::uint8_t> FindLeavers() const;
  void UpdateImages();
  std::array<Vector3, 3> MeasureStress() const;
  double FastestParticle() const;
  double FastestBody() const;
  std::size_t BodyCount() const { return planes_.size() + groups_.size() + meshes_.size(); }

  Program program_;
  Settings settings_;
  Kernels kernels_;
  LawConstants sphere_law_;
  ParticleStore particles_;
  Neighbours neighbours_;
  std::shared_ptr<Team> team_;
  Box box_;
  Images images_;
  Drive drive_;
  std::optional<CellDrive> cell_drive_;
  Vector3 filtered_stress_{};      // [Pa] along the edges
  std::int64_t filtered_at_ = -1;  // step of the filter's end, while the cell is not driven
  double shear_offset_ = 0;
  double shear_strain_ = 0;

  std::vector<PlaneBody> planes_;
  std::vector<GroupBody> groups_;
  std::vector<MeshBody> meshes_;
  std::vector<MeshContacts> mesh_contacts_;  // of meshes_
  std::vector<PlaneState> plane_states_;

  std::int64_t steps_ = 0;         // of this state since the start
  std::int64_t undone_steps_ = 0;  // that GoBackTo() left behind
  bool started_ = false;
  bool lists_stale_ = true;
  double travelled_ = 0;        // bound of any particle's way since the last prune [m]
  double travelled_outer_ = 0;  // since the last rebuild [m]
  std::int64_t steps_since_prune_ = 0;
  double inner_skin_ = 0;
  double outer_skin_ = 0;
  double pace_ = 0;  // recent bound of a particle's way in one step [m]
  double mean_diameter_ = 0;
  double largest_diameter_ = 0;

  // By slab, so that sums do not depend on threads.
  struct SlabSums {
    double fastest = 0;
    std::vector<Vector3> body_force;
  };
  std::vector<SlabSums> sums_;

  std::optional<Outcome> failure_;
  int leavers_ = 0;
  std::array<Vector3, 3> stress_{};
  Counters counters_;
};

}  // namespace powdercal::embedded
