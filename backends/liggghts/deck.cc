#include "backends/liggghts/deck.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/insertion.h"
#include "backends/liggghts/deck_model.h"
#include "backends/particle_summary.h"
#include "backends/servo_gain.h"
#include "scaling/groups.h"

namespace powdercal::liggghts {
namespace {

constexpr const char* kDumpColumns = "id type x y z radius vx vy vz omegax omegay omegaz";
constexpr const char* kDumpFormat =
    "sort id format \"%d %d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\"";
constexpr int kSeriesSteps = 100;
constexpr int kServoCheckSteps = 1000;
constexpr const char* kPrimitives[] = {"xplane", "yplane", "zplane"};

// Contacts that separate and meet again between two builds of the neighbour list keep their springs
// unless LIGGGHTS looks at pairs somewhat farther apart than touching (by this factor), too.
constexpr double kContactDistanceFactor = 1.02;

long long StepsOf(double duration, double time_step) {
  return std::max(1LL, static_cast<long long>(std::llround(duration / time_step)));
}

class DeckWriter {
 public:
  DeckWriter(const Program& program, const ParticleSummary& particles)
      : program_(program), particles_(particles) {}

  std::string Write() {
    Header();
    text_ += WriteProperties(program_);
    Simulation();
    for (stage_ = 0; stage_ < program_.stages.size(); ++stage_) {
      std::visit([this](const auto& stage) { Write(stage); }, program_.stages[stage_]);
    }
    return std::move(text_);
  }

 private:
  template <typename... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    text_ += fmt::format(format, std::forward<Args>(args)...);
    text_ += '\n';
  }

  // Sets a variable to what an expression is now: later runs or dumps do not change it.
  void Freeze(const char* name, const std::string& expression) {
    Add("variable formula equal {}\nvariable {} equal ${{formula}}", expression, name);
  }

  void Header() {
    const Materials& m = program_.materials;
    const auto letter = [&](std::size_t axis) {
      return program_.domain.boundaries[axis] == Boundary::periodic ? 'p' : 'f';
    };
    Add("# written by powdercal; experiment {}, program {}", program_.experiment, program_.Hash());
    Add("atom_style granular\natom_modify map array");
    Add("boundary {} {} {}", letter(0), letter(1), letter(2));
    Add("newton off\ncommunicate single vel yes\nunits si");
    if (program_.law.normal == ContactLaw::Normal::hertz) {
      // LIGGGHTS wants to be told of moduli outside its usual range.
      Add("hard_particles {}", m.young_modulus > 1e9 ? "yes" : "no");
      if (m.young_modulus < 5e6) Add("soft_particles yes");
    }
    Add("read_data {}", kDataFile);
    Add("neighbor {} bin", 0.1 * particles_.mean_diameter);
    const bool springs = program_.law.tangential == ContactLaw::Tangential::history ||
                         program_.law.rolling == ContactLaw::Rolling::epsd2;
    Add("neigh_modify delay 0 every 1 check yes contact_distance_factor {}",
        springs ? kContactDistanceFactor : 1.0);
  }

  void Simulation() {
    Add("pair_style {}", PairStyle(program_.law));
    Add("pair_coeff * *");
    Add("timestep {}", program_.time_step);
    Add("fix integrate all nve/sphere");
    if (Gravity() > 0) {
      const Vector3& g = program_.gravity;
      Add("fix gravity all gravity {} vector {} {} {}", Gravity(), g[0], g[1], g[2]);
    }
    for (std::size_t i = 0; i < program_.walls.size(); ++i) {
      const PlaneWall& wall = program_.walls[i];
      if (IsServo(wall.name)) continue;
      Add("fix wall_{} all {} primitive type {} {} {} {}", i, WallStyle(program_.law), TypeOf(wall),
          kPrimitives[wall.axis], wall.position, WallOptions(program_.law));
    }
    Add("compute radius all property/atom radius\nvariable top_of atom z+c_radius");
    Add("compute top all reduce max v_top_of\ncompute ke all ke\ncompute kr all erotate/sphere");
    Add("compute contacts all contact/atom\ncompute z all reduce ave c_contacts");
    Add("variable n equal atoms\nvariable start_n equal ${{n}}\nvariable now equal 0");
    Thermo("");
    Add("print \"PC START n=${{start_n}}\"");
  }

  // Lost atoms are ignored by default, and every thermo_style resets that.
  void Thermo(const std::string& columns) {
    Add("thermo_style custom step atoms c_ke c_kr c_top c_z{}", columns);
    Add("thermo 1000000000\nthermo_modify lost error norm no");
  }

  // Runs, then takes down what every stage looks at.
  void Run(const std::string& steps) {
    Add("run {} pre yes post no", steps);
    Freeze("now", "step");
    Freeze("energy", "c_ke+c_kr");
    Freeze("coordination", "c_z");
    Add("print \"PC CHECK stage={} step=${{now}} ke=${{energy}}\"", stage_);
  }

  // After a run: values as of its end.
  void EndStage(const std::string& more = "") {
    std::string servo;
    if (servo_) {
      Freeze("height", "v_h");
      Freeze("rise", "${height}-${z0}");
      servo = " h=${height} rise=${rise}";
    }
    Freeze("end_n", "v_n");
    Add("write_dump all custom {} {} modify {}", DumpFile(program_, stage_), kDumpColumns,
        kDumpFormat);
    Add("print \"PC END stage={} step=${{now}} n=${{end_n}} ke=${{energy}} "
        "z=${{coordination}}{}{}\"",
        stage_, servo, more);
  }

  void Write(const Insert&) {}  // the packing is in the data file

  void Write(const Settle& settle) {
    const long long steps = StepsOf(settle.check_interval, program_.time_step);
    const long long minimum = StepsOf(settle.min_duration, program_.time_step);
    const long long loops = StepsOf(settle.max_duration, program_.time_step) / steps + 1;
    // Kinetic energy over the sum of m g d of all particles.
    const double weight =
        particles_.Mass(program_.materials.density) * Gravity() * particles_.mean_diameter;
    Add("variable earliest equal ${{now}}+{}", minimum);
    Add("variable i{0} loop {1}\nlabel settle_{0}", stage_, loops);
    Run(fmt::to_string(steps));
    Add("if \"(${{energy}} < {1}) && (${{now}} >= ${{earliest}})\" then \"variable i{0} delete\" "
        "\"jump SELF settled_{0}\"",
        stage_, settle.kinetic_energy_ratio * weight);
    Add("next i{0}\njump SELF settle_{0}\nlabel settled_{0}", stage_);
    EndStage();
  }

  void Write(const Servo& servo) {
    const auto wall = std::find_if(program_.walls.begin(), program_.walls.end(),
                                   [&](const PlaneWall& w) { return w.name == servo.wall; });
    const double area = program_.domain.BaseArea();
    const Vector3& lower = program_.domain.lower;
    const double speed = ServoSpeed(program_, servo);
    const double limit = std::max(servo.max_velocity, speed);
    servo_ = servo;
    // Before the first run no thermo output has computed it.
    if (stage_ == FirstRun()) Run("0");
    Add("variable z0 equal c_top\nvariable z0 equal ${{z0}}+{}", 0.03 * particles_.mean_diameter);
    Add("fix lid all mesh/surface/stress/servo file {0} type {1} move {2} {3} ${{z0}} com {2} {3} "
        "${{z0}} ctrlPV force axis 0 0 -1 target_val {4} vel_max {5} kp {6}",
        kMeshFile, TypeOf(*wall), lower[0], lower[1], servo.stress * area, limit, speed / limit);
    Add("fix wall_lid all {} mesh n_meshes 1 meshes lid {}", WallStyle(program_.law),
        WallOptions(program_.law));
    Add("variable p equal -f_lid[3]/{}\nvariable h equal f_lid[9]", area);
    Add("fix series all ave/time 1 {0} {0} v_p v_h file {1}", kSeriesSteps, kSeriesFile);
    Thermo(" f_lid[3] f_lid[9]");
    Add("variable i{0} loop {1}\nlabel load_{0}", stage_,
        StepsOf(servo.max_duration, program_.time_step) / kServoCheckSteps + 1);
    Run(fmt::to_string(kServoCheckSteps));
    Freeze("borne", "abs(f_series[1])");
    Add("if \"${{borne}} > {1}\" then \"variable i{0} delete\" \"jump SELF loaded_{0}\"", stage_,
        0.9 * servo.stress);
    Add("next i{0}\njump SELF load_{0}\nlabel loaded_{0}", stage_);
    EndStage();
  }

  void Write(const Hold& hold) {
    const long long steps = StepsOf(hold.window, program_.time_step);
    const long long loops = StepsOf(hold.max_duration, program_.time_step) / steps + 1;
    const double duration = static_cast<double>(steps) * program_.time_step;
    // fix ave/time writes at multiples of its period only: align the windows with them.
    Freeze("align", fmt::format("ceil(${{now}}/{0})*{0}-${{now}}", steps));
    Run("${align}");
    Add("fix window_{0} all ave/time 1 {1} {1} v_p v_h", stage_, steps);
    Add("variable before equal 1\nvariable i{0} loop {1}\nlabel hold_{0}", stage_, loops);
    Freeze("h0", "v_h");
    Run(fmt::to_string(steps));
    Freeze("stress", fmt::format("f_window_{}[1]", stage_));
    Freeze("depth", fmt::format("f_window_{}[2]-({})", stage_, Floor()));
    Freeze("change", "abs(${depth}/${before}-1)");
    Add("variable before equal ${{depth}}");
    Freeze("velocity", fmt::format("(v_h-${{h0}})/{}", duration));
    Freeze("error", fmt::format("abs(abs(${{stress}})/{}-1)", servo_->stress));
    Freeze("quiet", fmt::format("${{energy}}/(${{depth}}*{})", ElasticEnergyPerHeight()));
    Freeze("rest", fmt::format("(${{change}}<{})*(${{error}}<{})*(${{quiet}}<{})",
                               hold.strain_rate * duration, hold.stress_tolerance,
                               hold.kinetic_energy_ratio));
    Add("if \"${{rest}} > 0\" then \"variable i{0} delete\" \"jump SELF held_{0}\"", stage_);
    Add("next i{0}\njump SELF hold_{0}\nlabel held_{0}\nunfix window_{0}", stage_);
    EndStage(" p=${stress} velocity=${velocity} change=${change} quiet=${quiet} rest=${rest}");
  }

  void Write(const Advance& advance) {
    const bool frames = advance.packing_every > 0;
    if (frames) {
      Add("variable next_{} equal step+{}", stage_, advance.packing_every);
      Add("dump frames_{} all custom 1 {} {}", stage_, FramesFile(program_, stage_), kDumpColumns);
      Add("dump_modify frames_{0} every v_next_{0} {1}", stage_, kDumpFormat);
    }
    Run(fmt::to_string(StepsOf(advance.duration, program_.time_step)));
    if (frames) Add("undump frames_{}", stage_);
    EndStage();
  }

  void Write(const Deform&) {}  // not supported
  void Write(const Save&) {}
  void Write(const Restore&) {}
  void Write(const Remove&) {}

  // Elastic energy of the bed under the servo's stress, per unit of its height [J/m]: stress times
  // area over kappa, which is the reciprocal of a relative overlap.
  double ElasticEnergyPerHeight() const {
    const Materials& m = program_.materials;
    const double stress = servo_->stress;
    const double kappa = program_.law.normal == ContactLaw::Normal::linear
                             ? m.linear.normal / (stress * particles_.mean_diameter)
                             : StiffnessNumber(m.young_modulus, m.poisson_ratio, stress);
    return stress * program_.domain.BaseArea() / kappa;
  }

  // Where the bed stands [m].
  double Floor() const {
    double floor = program_.domain.lower[2];
    for (const PlaneWall& wall : program_.walls) {
      if (wall.axis == 2 && wall.facing_positive) floor = std::max(floor, wall.position);
    }
    return floor;
  }

  double Gravity() const {
    const Vector3& g = program_.gravity;
    return std::hypot(g[0], g[1], g[2]);
  }

  bool IsServo(const std::string& wall) const {
    return std::any_of(program_.stages.begin(), program_.stages.end(), [&](const Stage& stage) {
      const Servo* servo = std::get_if<Servo>(&stage);
      return servo != nullptr && servo->wall == wall;
    });
  }

  // Index of the first stage that runs.
  std::size_t FirstRun() const {
    return std::holds_alternative<Insert>(program_.stages.front()) ? 1 : 0;
  }

  const Program& program_;
  const ParticleSummary particles_;
  std::optional<Servo> servo_;
  std::size_t stage_ = 0;
  std::string text_;
};

std::string WriteData(const Program& program, const Packing& packing) {
  const Domain& d = program.domain;
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
    text += fmt::format("{} {} {} {} {} {} {}\n", s.id, s.velocity[0], s.velocity[1], s.velocity[2],
                        s.spin[0], s.spin[1], s.spin[2]);
  }
  return text;
}

// A rectangle at z = 0 with one corner at the origin, facing down.
std::string WriteMesh(double x, double y) {
  using Corner = std::array<double, 2>;
  const auto facet = [](Corner a, Corner b, Corner c) {
    return fmt::format(
        "facet normal 0 0 -1\nouter loop\nvertex {} {} 0\nvertex {} {} 0\nvertex {} {} 0\n"
        "endloop\nendfacet\n",
        a[0], a[1], b[0], b[1], c[0], c[1]);
  };
  return "solid lid\n" + facet({0, 0}, {x, y}, {x, 0}) + facet({0, 0}, {0, y}, {x, y}) +
         "endsolid lid\n";
}

}  // namespace

std::string DumpFile(const Program& program, std::size_t stage) {
  return fmt::format("{}-{}.dump", stage, StageName(program.stages[stage]));
}

std::string FramesFile(const Program& program, std::size_t stage) {
  return fmt::format("{}-{}-frames.dump", stage, StageName(program.stages[stage]));
}

Input WriteInput(const Program& program) {
  const Insert* insert = std::get_if<Insert>(&program.stages.front());
  const Packing packing =
      PlaceParticles(program.particles, program.domain, insert != nullptr ? *insert : Insert{});
  Input input{.deck = DeckWriter(program, Summarise(program.particles)).Write(),
              .data = WriteData(program, packing),
              .particle_count = static_cast<int>(packing.size())};
  const bool servo =
      std::any_of(program.stages.begin(), program.stages.end(),
                  [](const Stage& stage) { return std::holds_alternative<Servo>(stage); });
  if (servo) input.mesh = WriteMesh(program.domain.Lengths()[0], program.domain.Lengths()[1]);
  return input;
}

}  // namespace powdercal::liggghts
