#include "torque/pseudo_inverse.h"

#include <Eigen/Cholesky>

namespace torqued
{

Reactions pseudo_inverse(const Support& support, const AdmissibleReactions& all, const ReactionTorques& torques,
                         const PseudoInverse& settings)
{
  // V, with zeros for the foot that is fixed
  const bool leading_sole = support.of(support.leading) == Contact::sole;
  const bool trailing_sole = support.of(support.trailing()) == Contact::sole;
  WrenchVector V = WrenchVector::Zero(all.w0.size());
  for (const Side side : kSides)
    if (const bool fixed = side == support.leading ? leading_sole && !trailing_sole : trailing_sole; !fixed)
    {
      const int components = wrench_components(support.of(side));
      V.segment(support.row(side), components) = settings.reaction_weights.head(components);
    }

  // the minimum over y of τᵀ W τ + λᵀ V λ, with τ = τ0 + T y and λ of w0 + Z y
  Bounded<kMaxJoints, 3> WT = torques.T;
  if (settings.weights.size() > 0)
    WT = settings.weights * torques.T;
  const Bounded<6, 3> VZ = V.asDiagonal() * all.Z;
  const Bounded<3, 3> H = torques.T.transpose() * WT + all.Z.transpose() * VZ;
  const BoundedVector<3> g = WT.transpose() * torques.tau0 + VZ.transpose() * all.w0;
  const BoundedVector<3> y = -H.llt().solve(g);
  return {all.w0 + all.Z * y};
}

} // namespace torqued
