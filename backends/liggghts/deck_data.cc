#include "backends/liggghts/deck_data.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/deck_model.h"
#include "backends/liggghts/stage_states.h"

namespace powdercal::liggghts {
namespace {

Vector3 Normal(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 u = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const Vector3 v = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const Vector3 n = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                     u[0] * v[1] - u[1] * v[0]};
  const double length = std::hypot(n[0], n[1], n[2]);
  return {n[0] / length, n[1] / length, n[2] / length};
}

std::string WriteStl(const Mesh& mesh) {
  std::string text = "solid mesh\n";
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t n) {
      return mesh.vertices[static_cast<std::size_t>(triangle[n])];
    };
    const Vector3 normal = Normal(corner(0), corner(1), corner(2));
    text += fmt::format("facet normal {} {} {}\nouter loop\n", normal[0], normal[1], normal[2]);
    for (std::size_t n = 0; n < 3; ++n) {
      const Vector3 v = corner(n);
      text += fmt::format("vertex {} {} {}\n", v[0], v[1], v[2]);
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid mesh\n";
}

// Over the domain's base at z = 0, facing down.
Mesh Rectangle(const Domain& domain) {
  const Vector3& l = domain.lower;
  const Vector3& u = domain.upper;
  return {.vertices = {{l[0], l[1], 0}, {u[0], l[1], 0}, {u[0], u[1], 0}, {l[0], u[1], 0}},
          .triangles = {{0, 2, 1}, {0, 3, 2}}};
}

}  // namespace

std::string WriteData(const Program& program, const Packing& packing) {
  const Domain& d = program.domain;
  std::set<std::int64_t> glued;
  for (const GluedGroup& group : program.groups) glued.insert(group.ids.begin(), group.ids.end());
  std::string text = fmt::format("powdercal packing\n\n{} atoms\n{} atom types\n\n", packing.size(),
                                 TypeCount(program));
  const char* axes[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format("{} {} {}lo {}hi\n", d.lower[i], d.upper[i], axes[i], axes[i]);
  }
  text += "\nAtoms\n\n";
  for (const Sphere& s : packing) {
    text += fmt::format("{} {} {} {} {} {} {}\n", s.id, kParticleType, 2 * s.radius,
                        program.materials.density, s.position[0], s.position[1], s.position[2]);
  }
  text += "\nVelocities\n\n";
  for (const Sphere& s : packing) {
    const bool rests = glued.contains(s.id);
    const Vector3 v = rests ? Vector3{} : s.velocity;
    const Vector3 w = rests ? Vector3{} : s.spin;
    text += fmt::format("{} {} {} {} {} {} {}\n", s.id, v[0], v[1], v[2], w[0], w[1], w[2]);
  }
  return text;
}

std::map<std::string, std::string> WriteMeshes(const Program& program) {
  std::map<std::string, std::string> files;
  const Servo* servo = FirstServo(program);
  if (servo != nullptr) files[kLidFile] = WriteStl(Rectangle(program.domain));
  for (std::size_t i = 0; i < program.meshes.size(); ++i) {
    const Mesh& mesh = program.meshes[i];
    const bool lid = servo != nullptr && mesh.name == servo->wall;
    files[lid ? kLidFile : MeshFile(i)] = WriteStl(mesh);
  }
  return files;
}

}  // namespace powdercal::liggghts
