#include "backends/embedded/kernels.h"

#include "core/errors.h"

namespace powdercal::embedded {
namespace {

const KernelTable& TableOf(Isa isa) {
  switch (isa) {
#ifdef POWDERCAL_X86_KERNELS
    case Isa::avx2:
      return kAvx2Kernels;
    case Isa::avx512:
      return kAvx512Kernels;
#endif
    default:
      return kPortableKernels;
  }
}

TangentialKernel TangentialOf(const ContactLaw& law) {
  if (law.tangential == ContactLaw::Tangential::no_history) return TangentialKernel::no_history;
  return law.shear_update == ContactLaw::ShearUpdate::displacement ? TangentialKernel::displacement
                                                                   : TangentialKernel::incremental;
}

}  // namespace

std::span<const std::string> IsaNames() {
  static const std::vector<std::string> names = {"portable", "avx2", "avx512"};
  return names;
}

bool Has(Isa isa) {
  if (isa == Isa::portable) return true;
#ifdef POWDERCAL_X86_KERNELS
  if (isa == Isa::avx2) return __builtin_cpu_supports("avx2") != 0;
  return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
         __builtin_cpu_supports("avx512vl") != 0;
#else
  return false;
#endif
}

Isa BestIsa() {
  if (Has(Isa::avx512)) return Isa::avx512;
  return Has(Isa::avx2) ? Isa::avx2 : Isa::portable;
}

Kernels KernelsFor(Isa isa, const ContactLaw& law) {
  const KernelTable& table = TableOf(isa);
  const auto normal = static_cast<std::size_t>(law.normal);
  const auto tangential = static_cast<std::size_t>(TangentialOf(law));
  const auto rolling = static_cast<std::size_t>(law.rolling);
  return {.isa = isa,
          .lanes = table.lanes,
          .pairs = table.pairs[normal][tangential][rolling],
          .plane = table.plane[normal][tangential][rolling],
          .surface = table.surface[normal][tangential][rolling],
          .prune = table.prune,
          .integrate = table.integrate};
}

}  // namespace powdercal::embedded
