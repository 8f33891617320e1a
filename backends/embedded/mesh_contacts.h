#pragma once

#include <cstdint>
#include <vector>

#include "backends/embedded/bodies.h"
#include "backends/embedded/contact_lists.h"
#include "backends/embedded/neighbours.h"
#include "backends/embedded/particle_store.h"
#include "backends/embedded/vector_math.h"

namespace powdercal::embedded {

/// The contacts of all particles with one mesh: candidates from the last rebuild, contacts found
/// anew in every step, histories handed from one step to the next by particle and nearest normal,
/// so that they pass from face to edge to face as a particle moves along.
class MeshContacts {
 public:
  explicit MeshContacts(HistoryKinds kinds) : kinds_(kinds) {}

  /// Finds the candidates within radius + skin [m] after the particles were sorted; a particle near
  /// a periodic side meets the mesh's images as well.
  void Rebuild(const ParticleStore& particles, const TriangleMesh& surface, const Box& box,
               const Images& images, const std::vector<Slab>& slabs, double skin);

  /// Forgets everything; nothing touches the mesh until the next Rebuild().
  void Clear(std::size_t slabs) { slabs_.assign(slabs, {}); }

  /// Adds the contact forces of a slab's particles to their loads and the force on the mesh to
  /// `force`, and keeps them for ForEachForce() if told to. Slabs may be worked on at the same
  /// time.
  void AddForces(std::size_t slab, std::int32_t padding_row, ParticleStore& particles,
                 const MeshBody& body, SurfaceKernel kernel, bool record, Vector3* force);

  /// Calls visit(overlap [m], radius [m]) for each contact of the last step.
  template <typename Visit>
  void ForEachContact(const Visit& visit) const {
    for (const SlabContacts& slab : slabs_) {
      for (const Remembered& contact : slab.memory) visit(contact.overlap, contact.radius);
    }
  }

  /// Calls visit(particle, branch [m] from the point of contact to its centre, force [N] on it) for
  /// each contact of the last step, which must have been recorded.
  template <typename Visit>
  void ForEachForce(const Visit& visit) const {
    for (const SlabContacts& slab : slabs_) {
      if (slab.near.empty()) continue;
      for (std::size_t n = 0; n < slab.contacts.size(); ++n) {
        const MeshContact& contact = slab.contacts[n];
        visit(slab.particle[n], contact.distance * contact.normal,
              Vector3{slab.list.force[0][n], slab.list.force[1][n], slab.list.force[2][n]});
      }
    }
  }

  /// See state_stream.h.
  template <typename Self, typename Stream>
  static void Transfer(Self& self, Stream& stream) {
    stream(self.candidates_, self.slabs_);
  }

 private:
  struct Near {  // a particle, or its image, near the mesh
    std::int32_t particle = 0;
    Vector3 shift{};          // [m] of the image
    std::uint32_t begin = 0;  // of its candidates
    std::uint32_t end = 0;

    template <typename Self, typename Stream>
    static void Transfer(Self& self, Stream& stream) {
      stream(self.particle, self.shift, self.begin, self.end);
    }
  };
  struct Remembered {
    std::int32_t particle = 0;
    std::int64_t id = 0;  // of the particle
    Vector3 normal{};
    double overlap = 0;  // [m]
    double radius = 0;   // [m] of the particle
    Vector3 shear{};
    Vector3 rolling{};
    bool taken = false;

    template <typename Self, typename Stream>
    static void Transfer(Self& self, Stream& stream) {
      stream(self.particle, self.id, self.normal, self.overlap, self.radius, self.shear,
             self.rolling, self.taken);
    }
  };
  struct SlabContacts {
    std::vector<Near> near;
    std::vector<Remembered> memory;  // in the order of the particles
    ContactList list;
    std::array<AlignedVector<double>, 3> normal;
    AlignedVector<double> distance;
    std::array<AlignedVector<double>, 3> velocity;
    std::vector<MeshContact> found;        // of one image
    std::vector<MeshContact> of_particle;  // of all its images
    std::vector<std::int32_t> particle;
    std::vector<MeshContact> contacts;

    template <typename Self, typename Stream>
    static void Transfer(Self& self, Stream& stream) {
      stream(self.near, self.memory, self.list, self.particle, self.contacts);
    }
  };

  void FindContacts(SlabContacts& slab, const ParticleStore& particles, const MeshBody& body);
  void Recall(SlabContacts& slab);
  void Remember(SlabContacts& slab, const ParticleStore& particles);

  HistoryKinds kinds_;
  std::vector<Candidate> candidates_;
  std::vector<SlabContacts> slabs_;
};

}  // namespace powdercal::embedded
