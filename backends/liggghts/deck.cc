#include "backends/liggghts/deck.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "backends/insertion.h"
#include "backends/servo_gain.h"
#include "scaling/groups.h"

namespace powdercal::liggghts {
namespace {

constexpr const char* kDumpColumns =
    "id type x y z radius vx vy vz omegax omegay omegaz modify sort id format \"%d %d %.17g %.17g "
    "%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\"";
constexpr int kSeriesSteps = 100;

long long StepsOf(double duration, double time_step) {
  return std::max(1LL, static_cast<long long>(std::llround(duration / time_step)));
}

std::string OnOff(bool flag) { return flag ? "on" : "off"; }

// The words after `model` in pair_style and fix wall/gran. In the latter, the options stand behind
// the geometry.
std::string ModelWords(const ContactLaw& law) {
  std::string words = fmt::format("hertz tangential {}",
                                  TangentialLawNames()[static_cast<std::size_t>(law.tangential)]);
  if (law.cohesion == ContactLaw::Cohesion::sjkr2) words += " cohesion sjkr2";
  if (law.rolling == ContactLaw::Rolling::cdt) words += " rolling_friction cdt";
  if (law.rolling == ContactLaw::Rolling::epsd2) words += " rolling_friction epsd2";
  return words;
}

std::string ModelOptions(const ContactLaw& law) {
  std::string words = "limitForce " + OnOff(law.limit_force);
  if (law.rolling != ContactLaw::Rolling::none) words += " torsionTorque " + OnOff(law.torsion);
  return words;
}

// Type 1: particles, type 2: walls.
std::string PairProperty(const char* fix, const char* property, double particles, double wall) {
  return fmt::format("fix {} all property/global {} peratomtypepair 2 {} {} {} {}\n", fix, property,
                     particles, wall, wall, wall);
}

class DeckWriter {
 public:
  explicit DeckWriter(const Program& program) : program_(program) {}

  std::string Write() {
    Header();
    Properties();
    for (const Stage& stage : program_.stages) {
      std::visit([this](const auto& s) { Write(s); }, stage);
    }
    return std::move(text_);
  }

 private:
  template <typename... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    text_ += fmt::format(format, std::forward<Args>(args)...);
    text_ += '\n';
  }

  void Header() {
    const Materials& m = program_.materials;
    Add("# written by powdercal; experiment {}, program {}", program_.experiment, program_.Hash());
    Add("atom_style granular\natom_modify map array");
    Add("boundary p p f\nnewton off\ncommunicate single vel yes\nunits si");
    // LIGGGHTS wants to be told of moduli outside its usual range.
    Add("hard_particles {}", m.young_modulus > 1e9 ? "yes" : "no");
    if (m.young_modulus < 5e6) Add("soft_particles yes");
    Add("read_data {}", kDataFile);
    Add("neighbor {} bin", 0.1 * program_.particles.sizes.mean);
    Add("neigh_modify delay 0 every 1 check yes");
  }

  void Properties() {
    const Materials& m = program_.materials;
    const ContactParameters& pp = m.particle_particle;
    const ContactParameters& pw = m.particle_wall;
    Add("fix m1 all property/global youngsModulus peratomtype {0} {0}", m.young_modulus);
    Add("fix m2 all property/global poissonsRatio peratomtype {0} {0}", m.poisson_ratio);
    text_ += PairProperty("m3", "coefficientRestitution", pp.restitution, pw.restitution);
    text_ += PairProperty("m4", "coefficientFriction", pp.friction, pw.friction);
    if (program_.law.cohesion == ContactLaw::Cohesion::sjkr2) {
      text_ += PairProperty("m5", "cohesionEnergyDensity", pp.cohesion_energy_density,
                            pw.cohesion_energy_density);
    }
    if (program_.law.rolling != ContactLaw::Rolling::none) {
      text_ += PairProperty("m6", "coefficientRollingFriction", pp.rolling_friction,
                            pw.rolling_friction);
    }
    Add("pair_style {}", PairStyle(program_.law));
    Add("pair_coeff * *");
    Add("timestep {}", program_.time_step);
    Add("fix integrate all nve/sphere");
    const Vector3& g = program_.gravity;
    const double magnitude = std::hypot(g[0], g[1], g[2]);
    if (magnitude > 0) {
      Add("fix gravity all gravity {} vector {} {} {}", magnitude, g[0], g[1], g[2]);
    }
    for (const PlaneWall& wall : program_.walls) {
      if (IsServo(wall.name)) continue;
      Add("fix wall_{} all wall/gran model {} primitive type 2 zplane {} {}", wall.name,
          ModelWords(program_.law), wall.position, ModelOptions(program_.law));
    }
    Add("compute radius all property/atom radius\nvariable top_of atom z+c_radius");
    Add("compute top all reduce max v_top_of\ncompute ke all ke\ncompute kr all erotate/sphere");
    Add("compute contacts all contact/atom\ncompute z all reduce ave c_contacts");
    Add("variable n equal atoms\nvariable start_n equal ${{n}}");
    Thermo("");
    Add("print \"PC START n=${{start_n}}\"");
  }

  // Lost atoms are ignored by default, and every thermo_style resets that.
  void Thermo(const char* columns) {
    Add("thermo_style custom step atoms c_ke c_kr c_top c_z{}", columns);
    Add("thermo 1000000000\nthermo_modify lost error norm no");
  }

  void Write(const Insert&) {}  // the packing is in the data file
  void Write(const Advance&) {}
  void Write(const Deform&) {}

  void Write(const Settle& settle) {
    const long long steps = StepsOf(settle.check_interval, program_.time_step);
    const long long minimum = StepsOf(settle.min_duration, program_.time_step);
    const long long loops = StepsOf(settle.max_duration, program_.time_step) / steps + 1;
    // Kinetic energy over the sum of m g d of all particles.
    const double weight =
        SolidMass() * std::abs(program_.gravity[2]) * program_.particles.sizes.Moment(1);
    Add("variable i loop {}\nlabel settle", loops);
    Add("run {} pre yes post no", steps);
    Add("variable ke equal c_ke+c_kr\nvariable a1 equal v_ke\nvariable a2 equal c_top\n"
        "variable a3 equal step\nvariable a4 equal c_z");
    Add("print \"PC SETTLE step=${{a3}} ke=${{a1}} top=${{a2}} z=${{a4}}\"");
    Add("if \"(${{a1}} < {}) && (${{a3}} >= {})\" then \"variable i delete\" \"jump SELF settled\"",
        settle.kinetic_energy_ratio * weight, minimum);
    Add("next i\njump SELF settle\nlabel settled");
    Add("write_dump all custom {} {}", DumpFile("settle"), kDumpColumns);
    Add("print \"PC STAGE settle step=${{a3}}\"");
  }

  void Write(const Servo& servo) {
    const double area = program_.domain.BaseArea();
    const double edge = program_.domain.Lengths()[0];
    const double speed = ServoSpeed(program_, servo);
    const double limit = std::max(servo.max_velocity, speed);
    servo_ = servo;
    Add("variable zw equal c_top\nvariable z0 equal ${{zw}}+{}",
        0.03 * program_.particles.sizes.mean);
    Add("fix {0} all mesh/surface/stress/servo file {1} type 2 scale {2} move {3} {4} ${{z0}} com "
        "{3} "
        "{4} ${{z0}} ctrlPV force axis 0 0 -1 target_val {5} vel_max {6} kp {7}",
        servo.wall, kMeshFile, edge, program_.domain.lower[0], program_.domain.lower[1],
        servo.stress * area, limit, speed / limit);
    Add("fix wall_{0} all wall/gran model {1} mesh n_meshes 1 meshes {0} {2}", servo.wall,
        ModelWords(program_.law), ModelOptions(program_.law));
    Add("variable p equal -f_{}[3]/{}\nvariable h equal f_{}[9]", servo.wall, area, servo.wall);
    Add("fix series all ave/time 1 {0} {0} v_p v_h file {1}", kSeriesSteps, kSeriesFile);
    Thermo(fmt::format(" f_{0}[3] f_{0}[9]", servo.wall).c_str());
    const long long steps = 1000;
    Add("variable j loop {}\nlabel load",
        StepsOf(servo.max_duration, program_.time_step) / steps + 1);
    Add("run {} pre yes post no", steps);
    Add("variable b1 equal f_series[1]\nvariable b2 equal f_series[2]\nvariable b3 equal step\n"
        "variable b4 equal c_ke+c_kr\nvariable b5 equal ${{b4}}");
    Add("print \"PC LOAD step=${{b3}} p=${{b1}} h=${{b2}} ke=${{b5}}\"");
    Add("variable borne equal abs(${{b1}})");
    Add("if \"${{borne}} > {}\" then \"variable j delete\" \"jump SELF loaded\"",
        0.9 * servo.stress);
    Add("next j");
    Add("jump SELF load");
    Add("label loaded\nprint \"PC STAGE servo step=${{b3}}\"");
  }

  void Write(const Hold& hold) {
    const long long steps = StepsOf(hold.window, program_.time_step);
    const long long loops = StepsOf(hold.max_duration, program_.time_step) / steps + 1;
    const double relative_change =
        hold.strain_rate * static_cast<double>(steps) * program_.time_step;
    const Materials& m = program_.materials;
    const double kappa = StiffnessNumber(m.young_modulus, m.poisson_ratio, servo_.stress);
    // Elastic energy of the bed, per unit of its height.
    const double energy = servo_.stress * program_.domain.BaseArea() / kappa;
    // fix ave/time writes at multiples of its period only: align the windows with them.
    Add("variable align equal ceil(${{b3}}/{0})*{0}-${{b3}}\nrun ${{align}} post no", steps);
    Add("fix window all ave/time 1 {0} {0} v_p v_h", steps);
    Add("variable before equal 1\nvariable rest equal 0\nvariable m loop {}\nlabel hold", loops);
    Add("run {} pre yes post no", steps);
    Add("variable d1 equal f_window[1]\nvariable d2 equal f_window[2]\nvariable d3 equal step\n"
        "variable d4 equal c_ke+c_kr\nvariable d5 equal ${{d4}}\nvariable d6 equal v_h\n"
        "variable d7 equal c_z");
    Add("variable change equal abs(${{d2}}/${{before}}-1)\nvariable before equal ${{d2}}");
    Add("variable error equal abs(abs(${{d1}})/{}-1)", servo_.stress);
    Add("variable quiet equal ${{d5}}/(${{d2}}*{})", energy);
    Add("print \"PC HOLD step=${{d3}} p=${{d1}} h=${{d2}} ke=${{d5}} z=${{d7}} change=${{change}} "
        "error=${{error}} quiet=${{quiet}}\"");
    Add("variable rest equal (${{change}}<{})*(${{error}}<{})*(${{quiet}}<{})", relative_change,
        hold.stress_tolerance, hold.kinetic_energy_ratio);
    Add("if \"${{rest}} > 0\" then \"variable m delete\" \"jump SELF held\"");
    Add("next m\njump SELF hold\nlabel held");
    Add("write_dump all custom {} {}", DumpFile("hold"), kDumpColumns);
    Add("variable end_n equal ${{n}}");
    Add("variable velocity equal (${{d2}}*${{change}})/{}",
        static_cast<double>(steps) * program_.time_step);
    Add("print \"PC RESULT rest=${{rest}} n=${{end_n}} step=${{d3}} p=${{d1}} h=${{d6}} ke=${{d5}} "
        "change=${{change}} quiet=${{quiet}} z=${{d7}} velocity=${{velocity}}\"");
  }

  bool IsServo(const std::string& wall) const {
    return std::any_of(program_.stages.begin(), program_.stages.end(), [&](const Stage& stage) {
      const Servo* servo = std::get_if<Servo>(&stage);
      return servo != nullptr && servo->wall == wall;
    });
  }

  double SolidMass() const {
    return program_.particles.count * program_.materials.density * std::numbers::pi / 6 *
           program_.particles.sizes.Moment(3);
  }

  const Program& program_;
  Servo servo_;
  std::string text_;
};

std::string WriteData(const Program& program, const Packing& packing) {
  const Domain& d = program.domain;
  std::string text = fmt::format("powdercal packing\n\n{} atoms\n2 atom types\n\n", packing.size());
  const char* axes[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format("{} {} {}lo {}hi\n", d.lower[i], d.upper[i], axes[i], axes[i]);
  }
  text += "\nAtoms\n\n";
  for (const Sphere& s : packing) {
    text += fmt::format("{} 1 {} {} {} {} {}\n", s.id, 2 * s.radius, program.materials.density,
                        s.position[0], s.position[1], s.position[2]);
  }
  text += "\nVelocities\n\n";
  for (const Sphere& s : packing) {
    text += fmt::format("{} {} {} {} {} {} {}\n", s.id, s.velocity[0], s.velocity[1], s.velocity[2],
                        s.spin[0], s.spin[1], s.spin[2]);
  }
  return text;
}

// The unit square at z = 0, facing down.
std::string WriteMesh() {
  const auto facet = [](const char* a, const char* b, const char* c) {
    return fmt::format(
        "facet normal 0 0 -1\nouter loop\nvertex {}\nvertex {}\nvertex {}\n"
        "endloop\nendfacet\n",
        a, b, c);
  };
  return "solid lid\n" + facet("0 0 0", "1 1 0", "1 0 0") + facet("0 0 0", "0 1 0", "1 1 0") +
         "endsolid lid\n";
}

}  // namespace

std::string PairStyle(const ContactLaw& law) {
  return fmt::format("gran model {} {}", ModelWords(law), ModelOptions(law));
}

std::string DumpFile(const std::string& moment) { return moment + ".dump"; }

std::string ExplainUnsupported(const Program& program) {
  const ContactLaw& law = program.law;
  if (law.normal != ContactLaw::Normal::hertz) {
    return "the linear normal law is not offered through LIGGGHTS yet; use hertz";
  }
  if (law.cohesion == ContactLaw::Cohesion::dmt) {
    return "LIGGGHTS has no DMT adhesion; use cohesion: sjkr2 or none";
  }
  if (law.tangential == ContactLaw::Tangential::history &&
      law.shear_update == ContactLaw::ShearUpdate::incremental) {
    return "LIGGGHTS stores the tangential displacement, not the force; use shear_update: "
           "displacement";
  }
  const Domain& d = program.domain;
  const std::array<Boundary, 3> wanted{Boundary::periodic, Boundary::periodic, Boundary::open};
  if (d.boundaries != wanted) return "only domains that are periodic in x and y and open in z";
  if (d.Lengths()[0] != d.Lengths()[1]) return "only square cells";
  if (!program.meshes.empty() || !program.groups.empty()) return "no meshes or glued groups";
  if (!program.particles.contacts.empty()) return "LIGGGHTS cannot be handed a contact history";
  const auto plain = [](const PlaneWall& wall) { return wall.axis == 2 && !wall.frictionless; };
  if (!std::all_of(program.walls.begin(), program.walls.end(), plain)) {
    return "only planes perpendicular to z, with friction";
  }
  static constexpr std::array<std::size_t, 4> kOrder = {0, 1, 2, 3};  // Insert, Settle, Servo, Hold
  const bool known =
      std::equal(program.stages.begin(), program.stages.end(), kOrder.begin(), kOrder.end(),
                 [](const Stage& stage, std::size_t index) { return stage.index() == index; });
  if (!known) return "only the stages insert, settle, servo, hold, in this order";
  return "";
}

Input WriteInput(const Program& program) {
  const Insert& insert = std::get<Insert>(program.stages.front());
  const Packing packing = PlaceParticles(program.particles, program.domain, insert);
  return {.deck = DeckWriter(program).Write(),
          .data = WriteData(program, packing),
          .mesh = WriteMesh(),
          .particle_count = static_cast<int>(packing.size())};
}

}  // namespace powdercal::liggghts
