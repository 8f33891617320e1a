#include "backends/liggghts/deck_bodies.h"

#include <algorithm>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/deck_model.h"
#include "backends/liggghts/stage_states.h"
#include "backends/servo_gain.h"

namespace powdercal::liggghts {
namespace {

constexpr const char* kPrimitives[] = {"xplane", "yplane", "zplane"};
constexpr std::size_t kIdsPerLine = 100;  // LIGGGHTS reads 2048 characters of a line

const PlaneWall* FindPlane(const Program& program, const std::string& name) {
  const auto found = std::find_if(program.walls.begin(), program.walls.end(),
                                  [&](const PlaneWall& wall) { return wall.name == name; });
  return found == program.walls.end() ? nullptr : &*found;
}

const Mesh* FindMesh(const Program& program, const std::string& name) {
  const auto found = std::find_if(program.meshes.begin(), program.meshes.end(),
                                  [&](const Mesh& mesh) { return mesh.name == name; });
  return found == program.meshes.end() ? nullptr : &*found;
}

// LIGGGHTS' name of a mesh or glued group.
std::string TagOf(const Program& program, const std::string& body) {
  for (std::size_t i = 0; i < program.meshes.size(); ++i) {
    if (program.meshes[i].name == body) return fmt::format("mesh_{}", i);
  }
  for (std::size_t i = 0; i < program.groups.size(); ++i) {
    if (program.groups[i].name == body) return fmt::format("group_{}", i);
  }
  return "";
}

}  // namespace

double LowestPoint(const Program& program, const Servo& servo) {
  const Mesh* mesh = FindMesh(program, servo.wall);
  if (mesh == nullptr) return 0;
  double lowest = mesh->vertices.front()[2];
  for (const Vector3& vertex : mesh->vertices) lowest = std::min(lowest, vertex[2]);
  return lowest;
}

DeckBodies::DeckBodies(const Program& program, DeckText& text) : program_(program), text_(text) {}

bool DeckBodies::IsServo(const std::string& body) const {
  const Servo* servo = FirstServo(program_);
  return servo != nullptr && servo->wall == body;
}

void DeckBodies::DefineGroups() {
  for (std::size_t i = 0; i < program_.groups.size(); ++i) {
    const std::vector<std::int64_t>& ids = program_.groups[i].ids;
    for (std::size_t first = 0; first < ids.size(); first += kIdsPerLine) {
      std::string line = fmt::format("group group_{} id", i);
      const std::size_t last = std::min(ids.size(), first + kIdsPerLine);
      for (std::size_t n = first; n < last; ++n) line += fmt::format(" {}", ids[n]);
      text_.Add("{}", line);
    }
  }
  if (program_.groups.empty()) return;
  std::string line = "group free subtract all";
  for (std::size_t i = 0; i < program_.groups.size(); ++i) line += fmt::format(" group_{}", i);
  text_.Add("{}", line);
}

void DeckBodies::Place(int segment) {
  segment_ = segment;
  for (std::size_t i = 0; i < program_.walls.size(); ++i) {
    const PlaneWall& wall = program_.walls[i];
    if (IsServo(wall.name) || removed_.contains(wall.name)) continue;
    text_.Add("fix wall_{} {} {} primitive type {} {} {} {}", i, free(), WallStyle(program_.law),
              TypeOf(wall), kPrimitives[wall.axis], wall.position, WallOptions(program_.law));
  }
  for (std::size_t i = 0; i < program_.meshes.size(); ++i) {
    const Mesh& mesh = program_.meshes[i];
    if (IsServo(mesh.name) || removed_.contains(mesh.name)) continue;
    text_.Add("fix mesh_{} all mesh/surface/stress file {} type {}", i, MeshFile(i), kWallType);
  }
  if (lid_) WriteLid();
  if (lid_loaded_) WriteIntegral();
  PlaceMeshWalls(false);
  for (std::size_t i = 0; i < program_.meshes.size(); ++i) {
    const Mesh& mesh = program_.meshes[i];
    if (IsServo(mesh.name) || removed_.contains(mesh.name)) continue;
    const std::string tag = fmt::format("mesh_{}", i);
    RecordForces(tag, "f_" + tag);
  }
  for (std::size_t i = 0; i < program_.groups.size(); ++i) {
    const std::string tag = fmt::format("group_{}", i);
    text_.Add("neigh_modify exclude group {0} {0}", tag);
    text_.Add("compute force_{0} {0} reduce sum fx fy fz", tag);
    RecordForces(tag, "c_force_" + tag);
  }
  if (lid_) RecordLid();
  RecordSlab();
}

void DeckBodies::RecordForces(const std::string& tag, const std::string& vector) {
  text_.Add("fix series_{0} all ave/time 1 {1} {1} {2}[1] {2}[2] {2}[3] file {3}", tag,
            kSeriesSteps, vector, SeriesFile(segment_, tag));
}

// LIGGGHTS takes one wall of meshes, for all of them.
void DeckBodies::PlaceMeshWalls(bool replace) {
  std::string meshes;
  int count = 0;
  for (std::size_t i = 0; i < program_.meshes.size(); ++i) {
    const std::string& name = program_.meshes[i].name;
    if (IsServo(name) || removed_.contains(name)) continue;
    meshes += fmt::format(" mesh_{}", i);
    ++count;
  }
  if (lid_) {
    meshes += " lid";
    ++count;
  }
  if (replace) text_.Add("unfix mesh_walls");
  if (count == 0) return;
  text_.Add("fix mesh_walls {} {} mesh n_meshes {} meshes{} {}", free(), WallStyle(program_.law),
            count, meshes, WallOptions(program_.law));
}

void DeckBodies::PlaceLid(const Servo& servo) {
  const bool others = std::any_of(
      program_.meshes.begin(), program_.meshes.end(),
      [&](const Mesh& mesh) { return mesh.name != servo.wall && !removed_.contains(mesh.name); });
  lid_ = servo;
  WriteLid();
  PlaceMeshWalls(others);
  RecordLid();
}

void DeckBodies::WriteLid() {
  const PlaneWall* plane = FindPlane(program_, lid_->wall);
  const double speed = ServoSpeed(program_, *lid_);
  const double limit = std::max(lid_->max_velocity, speed);
  text_.Add("variable lift equal ${{z0}}-({})", LowestPoint(program_, *lid_));
  text_.Add(
      "fix lid all mesh/surface/stress/servo file {} type {} move 0 0 ${{lift}} com 0 0 ${{z0}} "
      "ctrlPV force axis 0 0 -1 target_val {} vel_max {} kp {}",
      kLidFile, plane != nullptr ? TypeOf(*plane) : kWallType,
      lid_->stress * program_.domain.BaseArea(), limit, speed / limit);
}

void DeckBodies::RecordLid() {
  text_.Add("variable p equal -f_lid[3]/{}\nvariable h equal f_lid[9]", program_.domain.BaseArea());
  text_.Add("fix series_lid all ave/time 1 {0} {0} f_lid[1] f_lid[2] f_lid[3] f_lid[9] file {1}",
            kSeriesSteps, SeriesFile(segment_, "lid"));
}

void DeckBodies::ChangeLid(const Servo& servo) {
  lid_ = servo;
  text_.Add("fix_modify lid servo/target_val {}", servo.stress * program_.domain.BaseArea());
  StartIntegral();
}

// LIGGGHTS adds up the error from the servo's first step, whether or not there is an integral part,
// and takes from the sum what would be beyond the largest velocity. A step with hardly any velocity
// and an enormous gain therefore empties it.
void DeckBodies::StartIntegral() {
  lid_loaded_ = true;
  text_.Add(
      "fix_modify lid servo/vel_max 1e-12\nfix_modify lid servo/ctrlParam 1 1e30 0\n"
      "run 1 pre yes post no");
  text_.Add("fix_modify lid servo/vel_max {}",
            std::max(lid_->max_velocity, ServoSpeed(program_, *lid_)));
  WriteIntegral();
}

// The time of the integral is ten times what the bed takes to answer, whose stress grows by about
// 1.5 kappa sigma per strain: 10 h/(1.5 kappa P).
void DeckBodies::WriteIntegral() {
  const double speed = ServoSpeed(program_, *lid_);
  const double kp = speed / std::max(lid_->max_velocity, speed);
  const double rate = 0.15 * StiffnessUnder(program_, lid_->stress) * speed;
  text_.Freeze("integral", fmt::format("{}/(f_lid[9]-({}))", kp * rate, program_.domain.lower[2]));
  text_.Add("fix_modify lid servo/ctrlParam {} ${{integral}} 0", kp);
}

void DeckBodies::Remove(const std::string& body) {
  removed_.insert(body);
  for (std::size_t i = 0; i < program_.walls.size(); ++i) {
    if (program_.walls[i].name == body) text_.Add("unfix wall_{}", i);
  }
  const std::string tag = TagOf(program_, body);
  if (!tag.starts_with("mesh_")) return;
  text_.Add("unfix series_{}", tag);
  PlaceMeshWalls(true);
  text_.Add("unfix {}", tag);
}

void DeckBodies::StartMotions(const Advance& advance) {
  for (const Motion& motion : advance.motions) {
    const std::string tag = TagOf(program_, motion.body);
    const Vector3& v = motion.velocity;
    if (tag.starts_with("mesh_")) {
      text_.Add("fix move_{0} all move/mesh mesh {0} linear {1} {2} {3}", tag, v[0], v[1], v[2]);
    } else {
      text_.Add("velocity {} set {} {} {} units box", tag, v[0], v[1], v[2]);
      text_.Add("fix move_{0} {0} move linear {1} {2} {3} units box", tag, v[0], v[1], v[2]);
    }
  }
}

void DeckBodies::EndMotions(const Advance& advance) {
  for (const Motion& motion : advance.motions) {
    const std::string tag = TagOf(program_, motion.body);
    text_.Add("unfix move_{}", tag);
    if (!tag.starts_with("mesh_")) text_.Add("velocity {} set 0 0 0 units box", tag);
  }
}

// Sums over the free particles centred in the slab, of every twentieth step: they cost about as
// much as the step itself. LIGGGHTS' "stress" of a particle is minus half of the sum over its
// contacts with particles of branch vector times force, minus its m v v.
void DeckBodies::RecordSlab() {
  if (!program_.stress_slab) return;
  const auto [bottom, top] = *program_.stress_slab;
  text_.Add("region slab block INF INF INF INF {} {} units box", bottom, top);
  text_.Add("compute stress {} stress/atom ke pair", free());
  text_.Add("variable slab_m atom mass");
  for (const char axis : {'x', 'y', 'z'}) {
    text_.Add("variable slab_p{0} atom mass*v{0}", axis);
  }
  text_.Add(
      "compute slab {} reduce/region slab sum c_stress[1] c_stress[2] c_stress[3] c_stress[4] "
      "c_stress[5] c_stress[6] v_slab_m v_slab_px v_slab_py v_slab_pz",
      free());
  std::string values;
  for (int n = 1; n <= 10; ++n) values += fmt::format(" c_slab[{}]", n);
  text_.Add("fix series_slab all ave/time {} {} {}{} file {}", kSlabSteps,
            kSeriesSteps / kSlabSteps, kSeriesSteps, values, SeriesFile(segment_, "slab"));
}

void DeckBodies::SetState(const State& state) {
  removed_ = state.removed;
  lid_ = state.lid;
  lid_loaded_ = state.lid_loaded;
}

}  // namespace powdercal::liggghts
