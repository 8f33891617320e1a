#include "benchmarks/liggghts_insertion.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/deck_model.h"
#include "backends/liggghts/liggghts.h"
#include "backends/liggghts/result_files.h"
#include "core/files.h"

namespace powdercal::benchmarks {
namespace {

namespace fs = std::filesystem;

constexpr int kSizes = 8;
constexpr const char* kDump = "inserted.dump";

bool IsPrime(std::uint64_t n) {
  for (std::uint64_t d = 2; d * d <= n; ++d) {
    if (n % d == 0) return false;
  }
  return n > 1;
}

// LIGGGHTS takes primes above 10000 for seeds, and no seed twice.
class Primes {
 public:
  explicit Primes(std::uint64_t seed) : last_(20'000 + 1000 * seed) {}
  std::uint64_t Next() {
    do ++last_;
    while (!IsPrime(last_));
    return last_;
  }

 private:
  std::uint64_t last_;
};

std::vector<double> RadiiOf(const SizeDistribution& sizes) {
  if (sizes.kind == SizeDistribution::Kind::monodisperse) return {sizes.mean / 2};
  std::vector<double> radii;
  for (int i = 0; i < kSizes; ++i) radii.push_back(sizes.Quantile((i + 0.5) / kSizes) / 2);
  return radii;
}

std::string DeckOf(const Program& program) {
  const Domain& domain = program.domain;
  const Insert& insert = std::get<Insert>(program.stages.front());
  const std::vector<double> radii = RadiiOf(program.particles.sizes);
  Primes primes(program.particles.seed);
  std::string deck = "atom_style granular\natom_modify map array\nboundary p p f\nnewton off\n";
  deck += "communicate single vel yes\nunits si\n";
  const auto block = [&](const char* name, double bottom, double top) {
    deck += fmt::format("region {} block {} {} {} {} {} {} units box volume_limit 1e-18\n", name,
                        domain.lower[0], domain.upper[0], domain.lower[1], domain.upper[1], bottom,
                        top);
  };
  block("box", domain.lower[2], domain.upper[2]);
  deck += fmt::format("create_box {} box\nneighbor {} bin\nneigh_modify delay 0\n",
                      liggghts::TypeCount(program), 0.1 * program.particles.sizes.Moment(1));
  deck += liggghts::WriteProperties(program);
  deck += fmt::format("pair_style {}\npair_coeff * *\ntimestep {}\nfix move all nve/sphere\n",
                      liggghts::PairStyle(program.law), program.time_step);
  std::string shares;
  for (std::size_t i = 0; i < radii.size(); ++i) {
    deck += fmt::format(
        "fix size_{} all particletemplate/sphere {} atom_type 1 density constant {} radius "
        "constant {} volume_limit 1e-18\n",
        i, primes.Next(), program.materials.density, radii[i]);
    shares += fmt::format(" size_{} {}", i, 1.0 / static_cast<double>(radii.size()));
  }
  deck += fmt::format("fix sizes all particledistribution/discrete/numberbased {} {}{}\n",
                      primes.Next(), radii.size(), shares);
  block("slab", insert.bottom, insert.top);
  const Vector3& v = insert.velocity;
  deck += fmt::format(
      "fix insertion all insert/pack seed {} distributiontemplate sizes insert_every once "
      "overlapcheck yes all_in yes maxattempt 2000 vel constant {} {} {} particles_in_region {} "
      "region slab\nrun 1\n",
      primes.Next(), v[0], v[1], v[2], program.particles.count);
  deck += fmt::format("write_dump all custom {} {} modify {}", kDump, liggghts::kDumpColumns,
                      liggghts::kDumpFormat);
  return deck + "\n";
}

Packing RunInsertion(const std::string& deck, int count) {
  const fs::path folder =
      fs::temp_directory_path() / fmt::format("liggghts_insertion-{}", getpid());
  fs::create_directories(folder);
  WriteFileAtomically(folder / liggghts::kDeckFile, deck);
  const ProcessResult process = liggghts::RunDeck(folder, std::chrono::minutes(5));
  if (!process.succeeded()) {
    throw std::runtime_error(fmt::format("LIGGGHTS did not insert: {} {}", process.Describe(),
                                         ReadFile(folder / liggghts::kScreenFile)));
  }
  Packing packing = liggghts::ReadDump(folder / kDump).back().packing;
  fs::remove_all(folder);
  if (packing.size() != static_cast<std::size_t>(count)) {
    throw std::runtime_error(
        fmt::format("LIGGGHTS inserted {} of {} particles", packing.size(), count));
  }
  return packing;
}

}  // namespace

Packing InsertByLiggghts(const Program& program) {
  static std::map<std::string, Packing> known;  // by deck
  const std::string deck = DeckOf(program);
  const auto found = known.find(deck);
  if (found != known.end()) return found->second;
  return known[deck] = RunInsertion(deck, program.particles.count);
}

}  // namespace powdercal::benchmarks
