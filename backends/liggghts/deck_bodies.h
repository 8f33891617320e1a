#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "backends/liggghts/deck_text.h"
#include "backends/program.h"

namespace powdercal::liggghts {

/// Writes what concerns planes, meshes, glued groups and the slab of a deck, in LIGGGHTS' names:
///   wall_I, mesh_I, group_I   Program::walls[I], meshes[I], groups[I]
///   mesh_walls                the contacts of all meshes: it takes one `fix wall/gran` for them
///   lid                       the mesh that the servo moves
///   free                      the particles that are not glued ("all" where none are)
/// Glued particles are no part of gravity, of integration or of any wall's contacts, so that what
/// LIGGGHTS sums up on them is the force of the free particles alone. (A plane below a glued layer
/// would otherwise add a constant to it, that of a spring which never relaxes.)
///
/// Whenever the set of meshes changes (the servo's comes, one is removed), contacts with the others
/// forget their springs: the `fix wall/gran` is made anew.
class DeckBodies {
 public:
  DeckBodies(const Program& program, DeckText& text);

  /// The group of particles that move by themselves.
  std::string free() const { return program_.groups.empty() ? "all" : "free"; }

  /// Groups; at the beginning only, a restart knows them.
  void DefineGroups();
  /// Planes, meshes, records of forces and of the slab: what is there, after the beginning or a
  /// restart. `segment` numbers the files.
  void Place(int segment);
  /// Puts the servo's mesh at the height in the variable `z0`, and records its force.
  void PlaceLid(const Servo& servo);
  /// From here on the servo has an integral part, as the embedded engine's: a bed that creeps,
  /// dilates or compacts leaves a proportional servo behind (300 Pa: 13 % in the tests' shear cell;
  /// 450 Pa on creeping beds: 8 %). On its way down the lid goes without, since LIGGGHTS would sum
  /// up all of the way. The integral begins at zero, also after a restart.
  void StartIntegral();
  /// Gives the servo another stress; its integral begins anew.
  void ChangeLid(const Servo& servo);
  void Remove(const std::string& body);
  void StartMotions(const Advance& advance);
  void EndMotions(const Advance& advance);

  bool lid_placed() const { return lid_.has_value(); }
  /// The servo has its integral part.
  bool lid_loaded() const { return lid_loaded_; }

  /// What a restart has to bring back.
  struct State {
    std::set<std::string> removed;
    std::optional<Servo> lid;
    bool lid_loaded = false;
  };
  State state() const { return {removed_, lid_, lid_loaded_}; }
  void SetState(const State& state);

 private:
  void WriteLid();
  void WriteIntegral();
  void RecordLid();
  void PlaceMeshWalls(bool replace);
  void RecordForces(const std::string& tag, const std::string& vector);
  void RecordSlab();
  bool IsServo(const std::string& body) const;

  const Program& program_;
  DeckText& text_;
  std::set<std::string> removed_;
  std::optional<Servo> lid_;  ///< as it works now
  bool lid_loaded_ = false;
  int segment_ = 0;
};

/// Height of the lowest vertex [m] of the servo's mesh in its file; 0 of a plane.
double LowestPoint(const Program& program, const Servo& servo);

}  // namespace powdercal::liggghts
