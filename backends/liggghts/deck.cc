#include "backends/liggghts/deck.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "backends/insertion.h"
#include "backends/liggghts/deck_bodies.h"
#include "backends/liggghts/deck_data.h"
#include "backends/liggghts/deck_model.h"
#include "backends/liggghts/deck_text.h"
#include "backends/liggghts/stage_states.h"
#include "backends/particle_summary.h"

namespace powdercal::liggghts {
namespace {

constexpr int kServoCheckSteps = 1000;

// Contacts that separate and meet again between two builds of the neighbour list keep their springs
// unless LIGGGHTS looks at pairs somewhat farther apart than touching (by this factor), too.
constexpr double kContactDistanceFactor = 1.02;

std::string RestartFile(std::size_t stage) { return fmt::format("{}-save.restart", stage); }

long long StepsOf(double duration, double time_step) {
  return std::max(1LL, static_cast<long long>(std::llround(duration / time_step)));
}

class DeckWriter {
 public:
  DeckWriter(const Program& program, const ParticleSummary& particles)
      : program_(program), particles_(particles), bodies_(program, text_) {}

  std::string Write() {
    Header(fmt::format("read_data {}", kDataFile));
    bodies_.DefineGroups();
    Simulation();
    Add("variable n equal atoms\nvariable start_n equal ${{n}}\nvariable now equal 0");
    Add("variable shift equal 0\nvariable clock equal 0");
    Thermo();
    Add("print \"PC START n=${{start_n}}\"");
    for (stage_ = 0; stage_ < program_.stages.size(); ++stage_) {
      std::visit([this](const auto& stage) { Write(stage); }, program_.stages[stage_]);
    }
    return text_.Take();
  }

 private:
  template <typename... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    text_.Add(format, std::forward<Args>(args)...);
  }
  void Freeze(const std::string& name, const std::string& expression) {
    text_.Freeze(name, expression);
  }

  // With outflow sides, where LIGGGHTS deletes particles, it must not complain of lost ones. Open
  // sides then give way (m), so that whoever passes them is still there to be found.
  char BoundaryLetter(std::size_t axis) const {
    switch (program_.domain.boundaries[axis]) {
      case Boundary::periodic:
        return 'p';
      case Boundary::open:
        return HasOutflow(program_) ? 'm' : 'f';
      case Boundary::outflow:
        break;
    }
    return 'f';
  }

  void Header(const std::string& read) {
    const Materials& m = program_.materials;
    Add("# written by powdercal; experiment {}, program {}", program_.experiment, program_.Hash());
    Add("atom_style granular\natom_modify map array");
    Add("boundary {} {} {}", BoundaryLetter(0), BoundaryLetter(1), BoundaryLetter(2));
    Add("newton off\ncommunicate single vel yes\nunits si");
    if (program_.law.normal == ContactLaw::Normal::hertz) {
      // LIGGGHTS wants to be told of moduli outside its usual range.
      Add("hard_particles {}", m.young_modulus > 1e9 ? "yes" : "no");
      if (m.young_modulus < 5e6) Add("soft_particles yes");
    }
    Add("{}", read);
    Add("neighbor {} bin", 0.1 * particles_.mean_diameter);
    const bool springs = program_.law.tangential == ContactLaw::Tangential::history ||
                         program_.law.rolling == ContactLaw::Rolling::epsd2;
    Add("neigh_modify delay 0 every 1 check yes contact_distance_factor {}",
        springs ? kContactDistanceFactor : 1.0);
  }

  void Simulation() {
    text_.Append(WriteProperties(program_));
    Add("pair_style {}", PairStyle(program_.law));
    Add("pair_coeff * *");
    Add("timestep {}", program_.time_step);
    Add("fix integrate {} nve/sphere", bodies_.free());
    if (Gravity() > 0) {
      const Vector3& g = program_.gravity;
      Add("fix gravity {} gravity {} vector {} {} {}", bodies_.free(), Gravity(), g[0], g[1], g[2]);
    }
    bodies_.Place(segment_);
    Add("compute radius all property/atom radius\nvariable top_of atom z+c_radius");
    Add("compute top all reduce max v_top_of");
    Add("compute ke {0} ke\ncompute kr {0} erotate/sphere", bodies_.free());
    Add("compute contacts all contact/atom\ncompute z {} reduce ave c_contacts", bodies_.free());
    ran_ = false;
  }

  // Lost atoms are ignored by default, and every thermo_style resets that.
  void Thermo() {
    Add("thermo_style custom step atoms c_ke c_kr c_top c_z{}",
        bodies_.lid_placed() ? " f_lid[3] f_lid[9]" : "");
    Add("thermo 1000000000\nthermo_modify lost {} norm no",
        HasOutflow(program_) ? "ignore" : "error");
  }

  // Runs, then takes down what every stage looks at.
  void Run(const std::string& steps) {
    Add("run {} pre yes post no", steps);
    ran_ = true;
    Freeze("now", "step");
    Freeze("clock", "${now}+${shift}");
    Freeze("energy", "c_ke+c_kr");
    Freeze("coordination", "c_z");
    Add("print \"PC CHECK stage={} step=${{clock}} ke=${{energy}}\"", stage_);
  }

  // After a run: values as of its end.
  void EndStage(const std::string& more = "") {
    std::string servo;
    if (bodies_.lid_placed()) {
      Freeze("height", "v_h");
      Freeze("rise", "${height}-${z0}");
      servo = " h=${height} rise=${rise}";
    }
    Freeze("end_n", "v_n");
    Add("write_dump all custom {} {} modify {}", DumpFile(program_, stage_), kDumpColumns,
        kDumpFormat);
    Add("print \"PC END stage={} step=${{clock}} n=${{end_n}} ke=${{energy}} "
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
    const bool first = !bodies_.lid_placed();
    stress_ = servo.stress;
    if (first) {
      if (!ran_) Run("0");  // no thermo output has computed the top yet
      Add("variable z0 equal c_top\nvariable z0 equal ${{z0}}+{}", 0.03 * particles_.mean_diameter);
      bodies_.PlaceLid(servo);
      Thermo();
    } else {
      bodies_.ChangeLid(servo);
    }
    Freeze("latest", fmt::format("${{now}}+{}", StepsOf(servo.max_duration, program_.time_step)));
    if (first) {
      Press("touching", "${borne} > 0.5");
      bodies_.StartIntegral();
      Press("loaded", "${borne} > 0.9");
    } else {
      Press("loaded", "(${borne} > 0.9) && (${borne} < 1.1)");
    }
    EndStage();
  }

  // Runs until the servo's wall bears what `enough` says, or its time is over.
  void Press(const std::string& label, const std::string& enough) {
    Add("label {}_from_{}", label, stage_);
    Run(fmt::to_string(kServoCheckSteps));
    Freeze("borne", fmt::format("abs(f_series_lid[3])/{}", stress_ * program_.domain.BaseArea()));
    Add("if \"({0}) || (${{now}} >= ${{latest}})\" then \"jump SELF {1}_{2}\"", enough, label,
        stage_);
    Add("jump SELF {0}_from_{1}\nlabel {0}_{1}", label, stage_);
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
    Freeze("error", fmt::format("abs(abs(${{stress}})/{}-1)", stress_));
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
    bodies_.StartMotions(advance);
    Run(fmt::to_string(StepsOf(advance.duration, program_.time_step)));
    if (frames) Add("undump frames_{}", stage_);
    EndStage();
    bodies_.EndMotions(advance);
  }

  void Write(const Deform&) {}  // not supported

  // A restored servo's integral begins at zero, and so does that of the run that goes on.
  void Write(const Save& save) {
    if (bodies_.lid_loaded()) {
      bodies_.StartIntegral();
      Freeze("now", "step");
      Freeze("clock", "${now}+${shift}");
    }
    saved_[save.name] = {bodies_.state(), stress_, stage_};
    Add("print \"PC END stage={} step=${{clock}}\"", stage_);
    Add("write_restart {}", RestartFile(stage_));
    Add("variable step_{} equal ${{now}}", stage_);
    if (bodies_.lid_placed()) Add("variable z0_{} equal ${{z0}}", stage_);
  }

  // Variables survive `clear`. LIGGGHTS' count of steps goes back with the state.
  void Write(const Restore& restore) {
    const Saved& saved = saved_.at(restore.name);
    bodies_.SetState(saved.bodies);
    stress_ = saved.stress;
    ++segment_;
    Add("clear");
    Header(fmt::format("read_restart {}", RestartFile(saved.stage)));
    Freeze("now", fmt::format("${{step_{}}}", saved.stage));
    Freeze("shift", "${clock}-${now}");
    if (bodies_.lid_placed()) Add("variable z0 equal ${{z0_{}}}", saved.stage);
    Simulation();
    Thermo();
    Add("print \"PC RESTORE segment={} shift=${{shift}}\"", segment_);
  }

  void Write(const Remove& remove) { bodies_.Remove(remove.body); }

  // Elastic energy of the bed under the servo's stress, per unit of its height [J/m]: stress times
  // area over kappa.
  double ElasticEnergyPerHeight() const {
    return stress_ * program_.domain.BaseArea() / StiffnessUnder(program_, stress_);
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

  struct Saved {
    DeckBodies::State bodies;
    double stress = 0;
    std::size_t stage = 0;
  };

  const Program& program_;
  const ParticleSummary particles_;
  DeckText text_;
  DeckBodies bodies_;
  std::map<std::string, Saved> saved_;
  double stress_ = 0;  // [Pa] of the servo
  bool ran_ = false;   // since the beginning or the last restart
  int segment_ = 0;
  std::size_t stage_ = 0;
};

}  // namespace

std::string DumpFile(const Program& program, std::size_t stage) {
  return fmt::format("{}-{}.dump", stage, StageName(program.stages[stage]));
}

std::string FramesFile(const Program& program, std::size_t stage) {
  return fmt::format("{}-{}-frames.dump", stage, StageName(program.stages[stage]));
}

std::string MeshFile(std::size_t mesh) { return fmt::format("mesh-{}.stl", mesh); }

std::string SeriesFile(int segment, const std::string& tag) {
  return fmt::format("series-{}-{}.txt", segment, tag);
}

Input WriteInput(const Program& program) {
  const Insert* insert = std::get_if<Insert>(&program.stages.front());
  const Packing packing =
      PlaceParticles(program.particles, program.domain, insert != nullptr ? *insert : Insert{});
  Input input{.deck = DeckWriter(program, Summarise(program.particles)).Write(),
              .files = WriteMeshes(program),
              .particle_count = static_cast<int>(packing.size())};
  input.files[kDataFile] = WriteData(program, packing);
  return input;
}

}  // namespace powdercal::liggghts
