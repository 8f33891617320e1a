#include <fmt/format.h>

#include <algorithm>
#include <concepts>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "backends/program.h"
#include "core/errors.h"
#include "core/hash.h"

namespace powdercal {
namespace {

using Json = nlohmann::json;

// One Fields() per struct names its members; the same function serves writing and reading.
template <typename T, typename S>
concept Is = std::same_as<std::remove_const_t<T>, S>;

template <typename Io, Is<SizeDistribution> T>
void Fields(Io& io, T& sizes) {
  io.Enumeration("kind", sizes.kind, SizeDistributionNames());
  io("mean", sizes.mean);
  io("standard_deviation", sizes.standard_deviation);
  io("min", sizes.min);
  io("max", sizes.max);
}

template <typename Io, Is<ContactParameters> T>
void Fields(Io& io, T& contact) {
  io("restitution", contact.restitution);
  io("friction", contact.friction);
  io("rolling_friction", contact.rolling_friction);
  io("cohesion_energy_density", contact.cohesion_energy_density);
  io("surface_energy", contact.surface_energy);
}

template <typename Io, Is<LinearStiffness> T>
void Fields(Io& io, T& linear) {
  io("normal", linear.normal);
  io("tangential", linear.tangential);
  io("normal_damping", linear.normal_damping);
  io("tangential_damping", linear.tangential_damping);
}

template <typename Io, Is<Materials> T>
void Fields(Io& io, T& materials) {
  io("density", materials.density);
  io("young_modulus", materials.young_modulus);
  io("poisson_ratio", materials.poisson_ratio);
  io("particle_particle", materials.particle_particle);
  io("particle_wall", materials.particle_wall);
  io("linear", materials.linear);
}

template <typename Io, Is<ContactLaw> T>
void Fields(Io& io, T& law) {
  io.Enumeration("normal", law.normal, NormalLawNames());
  io("limit_force", law.limit_force);
  io.Enumeration("tangential", law.tangential, TangentialLawNames());
  io.Enumeration("shear_update", law.shear_update, ShearUpdateNames());
  io.Enumeration("cohesion", law.cohesion, CohesionNames());
  io.Enumeration("rolling", law.rolling, RollingNames());
  io("torsion", law.torsion);
  io.IfOn("tangential_reduce", law.tangential_reduce);
}

template <typename Io, Is<Particles> T>
void Fields(Io& io, T& particles) {
  io("sizes", particles.sizes);
  io("count", particles.count);
  io("seed", particles.seed);
  io("packing", particles.packing);
  io("contacts", particles.contacts);
}

std::span<const std::string> BoundaryNames() {
  static const std::vector<std::string> names = {"periodic", "open", "outflow"};
  return names;
}

template <typename Io, Is<Domain> T>
void Fields(Io& io, T& domain) {
  io("lower", domain.lower);
  io("upper", domain.upper);
  io.Enumeration("boundary_x", domain.boundaries[0], BoundaryNames());
  io.Enumeration("boundary_y", domain.boundaries[1], BoundaryNames());
  io.Enumeration("boundary_z", domain.boundaries[2], BoundaryNames());
}

template <typename Io, Is<PlaneWall> T>
void Fields(Io& io, T& wall) {
  io("name", wall.name);
  io("axis", wall.axis);
  io("position", wall.position);
  io("facing_positive", wall.facing_positive);
  io("frictionless", wall.frictionless);
}

template <typename Io, Is<Mesh> T>
void Fields(Io& io, T& mesh) {
  io("name", mesh.name);
  io("vertices", mesh.vertices);
  io("triangles", mesh.triangles);
}

template <typename Io, Is<GluedGroup> T>
void Fields(Io& io, T& group) {
  io("name", group.name);
  io("ids", group.ids);
}

template <typename Io, Is<Insert> T>
void Fields(Io& io, T& insert) {
  io("bottom", insert.bottom);
  io("top", insert.top);
  io("velocity", insert.velocity);
}

template <typename Io, Is<Settle> T>
void Fields(Io& io, T& settle) {
  io("kinetic_energy_ratio", settle.kinetic_energy_ratio);
  io("check_interval", settle.check_interval);
  io("min_duration", settle.min_duration);
  io("max_duration", settle.max_duration);
}

template <typename Io, Is<Servo> T>
void Fields(Io& io, T& servo) {
  io("wall", servo.wall);
  io("stress", servo.stress);
  io("max_velocity", servo.max_velocity);
  io("max_duration", servo.max_duration);
}

template <typename Io, Is<Hold> T>
void Fields(Io& io, T& hold) {
  io("stress_tolerance", hold.stress_tolerance);
  io("strain_rate", hold.strain_rate);
  io("kinetic_energy_ratio", hold.kinetic_energy_ratio);
  io("window", hold.window);
  io("max_duration", hold.max_duration);
}

template <typename Io, Is<Motion> T>
void Fields(Io& io, T& motion) {
  io("body", motion.body);
  io("velocity", motion.velocity);
  io("spin", motion.spin);
  io("centre", motion.centre);
}

template <typename Io, Is<Advance> T>
void Fields(Io& io, T& advance) {
  io("name", advance.name);
  io("duration", advance.duration);
  io("motions", advance.motions);
  io("packing_every", advance.packing_every);
}

template <typename Io, Is<EdgeControl> T>
void Fields(Io& io, T& edge) {
  io.Enumeration("kind", edge.kind, EdgeControlNames());
  io("value", edge.value);
}

template <typename Io, Is<Deform> T>
void Fields(Io& io, T& deform) {
  io("name", deform.name);
  io("duration", deform.duration);
  io("edges", deform.edges);
  io("shear_rate", deform.shear_rate);
  io("relaxation_rate", deform.relaxation_rate);
  io("gain", deform.gain);
}

template <typename Io, Is<Save> T>
void Fields(Io& io, T& save) {
  io("name", save.name);
}

template <typename Io, Is<Restore> T>
void Fields(Io& io, T& restore) {
  io("name", restore.name);
}

template <typename Io, Is<Remove> T>
void Fields(Io& io, T& remove) {
  io("body", remove.body);
}

template <typename Io, Is<Program> T>
void Fields(Io& io, T& program) {
  io("experiment", program.experiment);
  io("parameters", program.parameters);
  io.Enumeration("fidelity", program.fidelity, FidelityNames());
  io("particles", program.particles);
  io("materials", program.materials);
  io("law", program.law);
  io("domain", program.domain);
  io("walls", program.walls);
  io("meshes", program.meshes);
  io("groups", program.groups);
  io("gravity", program.gravity);
  io("time_step", program.time_step);
  io("stages", program.stages);
  io("stress_slab", program.stress_slab);
}

class Writer {
 public:
  template <typename T>
  void operator()(const char* key, const T& value) {
    object_[key] = Value(value);
  }
  template <typename T>
  void operator()(const char* key, const std::optional<T>& value) {
    if (value) object_[key] = Value(*value);
  }
  void IfOn(const char* key, bool value) {
    if (value) object_[key] = true;
  }
  template <typename E>
  void Enumeration(const char* key, E value, std::span<const std::string> names) {
    object_[key] = names[static_cast<std::size_t>(value)];
  }

  template <typename T>
  static Json Value(const T& value) {
    if constexpr (std::same_as<T, double>) {
      return value + 0.0;  // -0 and 0 are equal and must hash alike
    } else if constexpr (std::is_arithmetic_v<T> || std::same_as<T, std::string>) {
      return value;
    } else {
      Writer writer;
      Fields(writer, value);
      return std::move(writer.object_);
    }
  }
  static Json Value(const std::map<std::string, double>& values) {
    Json object = Json::object();
    for (const auto& [name, value] : values) object[name] = Value(value);
    return object;
  }
  static Json Value(const Sphere& sphere) {
    Json array = {sphere.id, Value(sphere.radius)};
    for (const Vector3* v : {&sphere.position, &sphere.velocity, &sphere.spin}) {
      for (const double x : *v) array.push_back(Value(x));
    }
    return array;
  }
  static Json Value(const ContactHistory& contact) {
    Json array = {contact.i, contact.j};
    for (const Vector3* v : {&contact.shear, &contact.rolling}) {
      for (const double x : *v) array.push_back(Value(x));
    }
    return array;
  }
  static Json Value(const Stage& stage) {
    Json object = std::visit([](const auto& alternative) { return Value(alternative); }, stage);
    object["stage"] = StageName(stage);
    return object;
  }
  template <typename T>
  static Json Value(const std::vector<T>& items) {
    return Array(items);
  }
  template <typename T, std::size_t size>
  static Json Value(const std::array<T, size>& items) {
    return Array(items);
  }

 private:
  static Json Array(const auto& items) {
    Json array = Json::array();
    for (const auto& item : items) array.push_back(Value(item));
    return array;
  }

  Json object_ = Json::object();
};

[[noreturn]] void Fail(const std::string& path, const std::string& problem) {
  throw InputError(problem, {.key = path});
}

class Reader {
 public:
  Reader(const Json& object, std::string path) : object_(object), path_(std::move(path)) {
    if (!object.is_object()) Fail(path_, "expected an object");
  }

  template <typename T>
  void operator()(const char* key, T& value) {
    Into(Member(key), PathTo(key), value);
  }
  template <typename T>
  void operator()(const char* key, std::optional<T>& value) {
    value.reset();
    seen_.emplace_back(key);
    if (object_.contains(key)) Into(object_.at(key), PathTo(key), value.emplace());
  }
  void IfOn(const char* key, bool& value) {
    std::optional<bool> written;
    (*this)(key, written);
    value = written.value_or(false);
  }
  template <typename E>
  void Enumeration(const char* key, E& value, std::span<const std::string> names) {
    std::string name;
    (*this)(key, name);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] != name) continue;
      value = static_cast<E>(i);
      return;
    }
    throw UnknownName("name", name, names, {.key = PathTo(key)});
  }

  void Finish() const {
    for (const auto& item : object_.items()) {
      if (std::find(seen_.begin(), seen_.end(), item.key()) == seen_.end()) {
        throw UnknownName("member", item.key(), seen_, {.key = path_});
      }
    }
  }

  template <typename T>
  static void Into(const Json& json, const std::string& path, T& value) {
    if constexpr (std::is_class_v<T>) {
      Reader reader(json, path);
      Fields(reader, value);
      reader.Finish();
    } else if constexpr (std::same_as<T, bool>) {
      if (!json.is_boolean()) Fail(path, "expected true or false");
      value = json.get<bool>();
    } else if constexpr (std::integral<T>) {
      if (!json.is_number_integer()) Fail(path, "expected an integer");
      value = json.get<T>();
      if (Json(value) != json) Fail(path, "the integer is out of range");
    } else {
      if (!json.is_number()) Fail(path, "expected a number");
      value = json.get<T>();
    }
  }
  static void Into(const Json& json, const std::string& path, std::string& value) {
    if (!json.is_string()) Fail(path, "expected a text");
    value = json.get<std::string>();
  }
  template <typename T, std::size_t size>
  static void Into(const Json& json, const std::string& path, std::array<T, size>& items) {
    RequireArray(json, path, size);
    for (std::size_t i = 0; i < size; ++i) Into(json[i], fmt::format("{}[{}]", path, i), items[i]);
  }
  static void Into(const Json& json, const std::string& path,
                   std::map<std::string, double>& values) {
    if (!json.is_object()) Fail(path, "expected an object");
    values.clear();
    for (const auto& item : json.items()) {
      Into(item.value(), path + "." + item.key(), values[item.key()]);
    }
  }
  static void Into(const Json& json, const std::string& path, Sphere& sphere) {
    RequireArray(json, path, 11);
    Into(json[0], path, sphere.id);
    Into(json[1], path, sphere.radius);
    std::size_t next = 2;
    for (Vector3* v : {&sphere.position, &sphere.velocity, &sphere.spin}) {
      for (double& x : *v) Into(json[next++], path, x);
    }
  }
  static void Into(const Json& json, const std::string& path, ContactHistory& contact) {
    RequireArray(json, path, 8);
    Into(json[0], path, contact.i);
    Into(json[1], path, contact.j);
    std::size_t next = 2;
    for (Vector3* v : {&contact.shear, &contact.rolling}) {
      for (double& x : *v) Into(json[next++], path, x);
    }
  }
  static void Into(const Json& json, const std::string& path, Stage& stage) {
    if (!json.is_object() || !json.contains("stage")) Fail(path, "expected an object with 'stage'");
    std::string name;
    Into(json["stage"], path + ".stage", name);
    Json rest = json;
    rest.erase("stage");
    std::vector<std::string> names;
    for (Stage candidate :
         {Stage(Insert()), Stage(Settle()), Stage(Servo()), Stage(Hold()), Stage(Advance()),
          Stage(Deform()), Stage(Save()), Stage(Restore()), Stage(Remove())}) {
      names.push_back(StageName(candidate));
      if (names.back() != name) continue;
      std::visit([&](auto& alternative) { Into(rest, path, alternative); }, candidate);
      stage = candidate;
      return;
    }
    throw UnknownName("stage", name, names, {.key = path});
  }
  template <typename T>
  static void Into(const Json& json, const std::string& path, std::vector<T>& items) {
    if (!json.is_array()) Fail(path, "expected an array");
    items.clear();
    items.reserve(json.size());
    for (const Json& item : json) {
      const std::string item_path = fmt::format("{}[{}]", path, items.size());
      Into(item, item_path, items.emplace_back());
    }
  }

 private:
  static void RequireArray(const Json& json, const std::string& path, std::size_t size) {
    if (!json.is_array() || json.size() != size) {
      Fail(path, fmt::format("expected an array of {} items", size));
    }
  }

  const Json& Member(const char* key) {
    seen_.emplace_back(key);
    if (!object_.contains(key)) Fail(PathTo(key), "the member is missing");
    return object_.at(key);
  }

  std::string PathTo(const char* key) const { return path_.empty() ? key : path_ + "." + key; }

  const Json& object_;
  std::string path_;
  std::vector<std::string> seen_;
};

}  // namespace

nlohmann::json Program::ToJson() const { return Writer::Value(*this); }

Program Program::FromJson(const nlohmann::json& json) {
  Program program;
  Reader::Into(json, "", program);
  return program;
}

std::string Program::Hash() const { return Sha256(ToJson().dump()); }

}  // namespace powdercal
