function [mass_matrix, generalized_forces, constraint_jacobian, constraint_bias] = scene_dynamics(t, q, qd, p)
    %SCENE_DYNAMICS All that the accelerations need; there are no constraints.
    mass_matrix = scene_mass_matrix(q, p);
    generalized_forces = scene_generalized_forces(t, q, qd, p);
    constraint_jacobian = zeros(0, numel(q));
    constraint_bias = zeros(0, 1);
end
