function mass_matrix = scene_mass_matrix(q, p)
    %SCENE_MASS_MATRIX The mass matrix, whose columns are the momenta for unit rates.
    units = eye(numel(q));
    columns = arrayfun(@(j) scene_momenta(q, units(:, j), p), 1:numel(q), 'UniformOutput', false);
    mass_matrix = tril([columns{:}]);
    mass_matrix = mass_matrix + tril(mass_matrix, -1).';
end
